#include "sim/models/field_kinds.h"

namespace powbench::sim {
namespace {

FieldRung table_rung(const Specimen& s, FieldTables& tables) {
  const auto table = tables.drawn_or_plane(s);
  return pure_field("table", table->table().description, table);
}

std::string unknown_to_ends(const Specimen& s) {
  if (s.in_space) return has_three_dimensions(s);
  if (s.drawn)
    return "allowed table, solved: the drawing of specimen '" + s.name + "' is no magnet in three dimensions";
  return no_elements(s);
}

FieldRung end_rung(const Specimen& s, FieldTables& tables) {
  const auto table = tables.with_ends(s);
  return pure_field("ends", table->table().description, table);
}

}  // namespace

FieldRung pure_field(std::string name, std::string meaning,
                     std::shared_ptr<const MagneticPotential> potential) {
  return {std::move(name), std::move(meaning), [potential](const Case&) { return potential; }, false, false};
}

Fields table_fields() {
  return {.name = "table", .costly = false, .unknown = no_elements, .rung = table_rung};
}

Fields end_fields() {
  return {.name = "ends", .costly = false, .unknown = unknown_to_ends, .rung = end_rung};
}

}  // namespace powbench::sim
