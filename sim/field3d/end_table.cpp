#include "sim/field3d/end_table.h"

#include <algorithm>
#include <array>

namespace powbench::sim {
namespace {

/// The four cubics of Hermite at t in 0 .. 1 over a cell of this width, and their slopes: value at the lower end, slope
/// there, value at the upper end, slope there.
struct Cubics {
  std::array<double, 4> value, slope;
  Cubics(double t, double width)
      : value{1 - t * t * (3 - 2 * t), width * t * (1 - t) * (1 - t), t * t * (3 - 2 * t),
              width * t * t * (t - 1)},
        slope{-6 * t * (1 - t) / width, (1 - t) * (1 - 3 * t), 6 * t * (1 - t) / width, t * (3 * t - 2)} {}
};

std::size_t cell_of(const std::vector<double>& nodes, double x) {
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x);
  return static_cast<std::size_t>(above - nodes.begin()) - 1;
}

/// W, W_psi, W_gap and W_psi,gap of a table of two variables at a point inside. Not TablePotential: a difference of
/// energies is not convex.
std::array<double, 4> inside(const PotentialTable& t, double psi, double gap) {
  const std::size_t p = cell_of(t.psi, psi), g = cell_of(t.gap, gap);
  const double wp = t.psi[p + 1] - t.psi[p], wg = t.gap[g + 1] - t.gap[g];
  const Cubics a((psi - t.psi[p]) / wp, wp), b((gap - t.gap[g]) / wg, wg);
  std::array<double, 4> out{};
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t node = p + i / 2 + t.psi.size() * (g + j / 2);
      const double f = t.nodes[node * 4 + i % 2 + 2 * (j % 2)];
      out[0] += f * a.value[i] * b.value[j];
      out[1] += f * a.slope[i] * b.value[j];
      out[2] += f * a.value[i] * b.slope[j];
      out[3] += f * a.slope[i] * b.slope[j];
    }
  return out;
}

}  // namespace

PotentialTable build_table_with_ends(const MagnetDesign& given, const TableOptions& options,
                                     const EndTableOptions& ends, Team& team, TableReport* report) {
  TableOptions open = options;
  open.ring = false;
  MagnetDesign design = given;
  constexpr double little = 0.05;  // A: unsaturated
  design.end_leakage = end_corrections(given, ends.sizes, little, {ends.leakage_gap}).front().leakage;
  PotentialTable table = build_table(design, open, team, report);

  open.psi_nodes = ends.psi_nodes;
  open.gap_nodes = ends.gap_nodes;
  CoreMeshSizes3 flat = ends.sizes;
  flat.ends = false;
  PotentialTable bracket = build_table3(design, ends.sizes, open);
  const PotentialTable plane = build_table3(design, flat, open);
  for (std::size_t n = 0; n < bracket.nodes.size(); ++n) bracket.nodes[n] -= plane.nodes[n];

  for (std::size_t g = 0, n = 0; g < table.gap.size(); ++g)
    for (std::size_t p = 0; p < table.psi.size(); ++p)
      for (const double more : inside(bracket, table.psi[p], table.gap[g])) table.nodes[n++] += more;
  table.air = air_of_core3(design, ends.sizes, table.gap);
  estimate_errors(table);
  table.design_hash = end_table_hash(given, options, ends);
  table.description += ", with ends";
  return table;
}

std::uint64_t end_table_hash(const MagnetDesign& design, const TableOptions& options,
                             const EndTableOptions& ends) {
  TableOptions open = options;
  open.ring = false;
  std::uint64_t hash = table_hash(design, open);
  const auto& s = ends.sizes;
  for (const double value :
       {s.corner, s.other, s.largest, s.far, s.growth, static_cast<double>(s.layers),
        static_cast<double>(ends.psi_nodes), static_cast<double>(ends.gap_nodes), ends.leakage_gap})
    hash = mixed_hash(hash, value);
  return hash;
}

}  // namespace powbench::sim
