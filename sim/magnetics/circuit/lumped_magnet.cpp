#include "sim/magnetics/circuit/lumped_magnet.h"

#include <stdexcept>

namespace powbench::sim {

Steel steel_of(const Magnet& m) {
  if (m.steel.empty()) return Steel::power_law(m.bh_linear, m.bh_power, m.bh_exponent);
  if (m.steel_b.empty() && m.steel_h.empty()) return builtin_steel(m.steel);
  if (m.steel_b.size() != m.steel_h.size())
    throw std::invalid_argument("steel '" + m.steel + "': " + std::to_string(m.steel_b.size()) +
                                " values of B, " + std::to_string(m.steel_h.size()) +
                                " of H, allowed as many of both");
  std::vector<BhRow> rows;
  for (std::size_t k = 0; k < m.steel_b.size(); ++k) rows.push_back({m.steel_b[k], m.steel_h[k]});
  return Steel::table(m.steel, std::move(rows));
}

}  // namespace powbench::sim
