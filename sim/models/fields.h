#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/magnetics/potential.h"
#include "sim/magnetics/table/potential_table.h"
#include "sim/models/rung.h"

/// The kinds of fields, one file each. A new one is a file with a `Fields`, and a line in fields.cpp: help, plans,
/// `auto` and messages follow from it.

namespace powbench::sim {

struct DrawnMagnet;  // sim/magnetics/plane/drawn_magnet.h

/// A rung of fields. `potential` is asked once for each run: one that keeps a state between calls is made anew there.
struct FieldRung {
  std::string name;     ///< of its Fields
  std::string meaning;  ///< one line
  std::function<std::shared_ptr<const MagneticPotential>(const Case&)> potential;
  bool pressed_gap = false;  ///< also defined for gap < 0
  bool costly = false;       ///< seconds a closing
};

/// Where tables come from: built, or kept from an earlier time.
class FieldTables {
 public:
  virtual ~FieldTables() = default;
  virtual TableOptions options(const Specimen&) const = 0;
  /// Of the specimen's drawing or, plane and with the ring, of its shape.
  virtual std::shared_ptr<const TablePotential> drawn_or_plane(const Specimen&) = 0;
  /// Of its shape, with what the ends of three dimensions add.
  virtual std::shared_ptr<const TablePotential> with_ends(const Specimen&) = 0;
};

/// One kind of fields.
struct Fields {
  std::string_view name;
  bool costly;                              ///< solves them at every step: seconds a closing and more
  std::string (*unknown)(const Specimen&);  ///< why the specimen has none, one sentence; empty: it has
  FieldRung (*rung)(const Specimen&, FieldTables&);
};

/// Coarse to fine.
std::span<const Fields> all_fields();
/// Place in all_fields(); its length for an unknown name.
std::size_t place_of_fields(std::string_view name);
/// Those that a choice may climb, coarse to fine: known to the specimen and not costly.
std::vector<std::string> automatic_fields(const Specimen&);

/// The lumped circuit with the specimen's own numbers.
FieldRung circuit_field();
/// A potential that is pure: a table.
FieldRung pure_field(std::string name, std::string meaning, std::shared_ptr<const MagneticPotential>);
/// Plane finite elements solved anew at every look of the integrator, each from the solution before: no table between
/// field and motion.
FieldRung solved_field(const MagnetDesign&, const FieldOptions&);
FieldRung solved_field(const std::shared_ptr<const DrawnMagnet>&, const NewtonOptions&);

/// The magnet of a specimen: its shape, steel law, turns and residual gap.
MagnetDesign magnet_design(const Specimen&);

/// "a, b or c", of `all_fields` or `all_mechanics`.
template <class Kind>
std::string names_of(std::span<const Kind> kinds, std::string_view last = " or ") {
  std::string out;
  for (std::size_t k = 0; k < kinds.size(); ++k)
    out += (k == 0 ? "" : std::string(k + 1 < kinds.size() ? ", " : last)) + std::string(kinds[k].name);
  return out;
}

}  // namespace powbench::sim
