#include "sim/models/fields.h"

#include <array>

#include "sim/magnetics/circuit/lumped_magnet.h"
#include "sim/models/field_kinds.h"

namespace powbench::sim {

std::span<const Fields> all_fields() {
  static const std::array kinds{circuit_fields(), table_fields(), solved_fields(), end_fields()};
  return kinds;
}

std::size_t place_of_fields(std::string_view name) {
  const auto kinds = all_fields();
  std::size_t k = 0;
  while (k < kinds.size() && kinds[k].name != name) ++k;
  return k;
}

std::vector<std::string> automatic_fields(const Specimen& s) {
  std::vector<std::string> out;
  for (const Fields& f : all_fields())
    if (!f.costly && f.unknown(s).empty()) out.emplace_back(f.name);
  return out;
}

std::string no_elements(const Specimen& s) {
  if (s.drawn || s.in_space || s.shaped) return "";
  if (!s.magnet.drawing.empty())
    return "the drawing '" + s.magnet.drawing + "' of the stored specimen '" + s.name +
           "' is not at hand; name its specimen file";
  return "allowed circuit, for specimen '" + s.name +
         "' has no [shape] with a key in it: whose magnet the fields are is not known";
}

std::string has_three_dimensions(const Specimen& s) {
  return "allowed table: that of the drawing in space of specimen '" + s.name + "' is of three dimensions";
}

MagnetDesign magnet_design(const Specimen& s) {
  MagnetDesign d;
  d.shape = s.shape;
  d.steel = steel_of(s.magnet);
  d.turns = s.coil.turns;
  d.residual_gap = s.magnet.residual_gap;
  return d;
}

}  // namespace powbench::sim
