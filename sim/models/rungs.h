#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/magnetics/plane/magnet_field.h"
#include "sim/magnetics/potential.h"
#include "sim/study/ladder.h"

/// Any fields with any mechanics: the pairs that a scene may name.

namespace powbench::sim {

/// A rung of fields. `potential` is asked once for each run: one that keeps a state between calls is made anew there.
struct FieldRung {
  std::string name;     ///< circuit, table, field2d, field3d
  std::string meaning;  ///< one line
  std::function<std::shared_ptr<const MagneticPotential>(const Case&)> potential;
  bool pressed_gap = false;  ///< also defined for gap < 0
  bool costly = false;       ///< seconds a closing
};

/// The lumped circuit with the specimen's own numbers.
FieldRung circuit_field();
/// A potential that is pure: a table.
FieldRung pure_field(std::string name, std::string meaning, std::shared_ptr<const MagneticPotential>);
/// Plane finite elements solved anew at every look of the integrator, each from the solution before: no table between
/// field and motion.
FieldRung live_field(const MagnetDesign&, const FieldOptions&);
FieldRung live_field(const std::shared_ptr<const DrawnMagnet>&, const NewtonOptions&);

/// The magnet of a specimen: its shape, steel law, turns and residual gap.
MagnetDesign magnet_design(const Specimen&);

inline constexpr std::array<std::string_view, 4> field_names{"circuit", "table", "field2d", "field3d"};
inline constexpr std::array<std::string_view, 4> mechanics_names{"plant", "rigid", "modal", "explicit"};

/// How far `explicit` goes: its times after the bounces are not reliable, and every ms costs a second.
inline constexpr double explicit_duration = 0.03;  // s

/// What of a case these mechanics do not model, in one sentence; empty: nothing. Their rungs throw it as
/// std::invalid_argument.
std::string unknown_to(std::string_view mechanics, const Case&);

/// The pair as a rung. Settings: `plant` and `rigid` take tolerances, `modal` the share of its critical step,
/// `explicit` the edge of its cells in mm. Throws std::invalid_argument for an unknown name, and for `plant` with
/// other fields than `circuit`: the plant has its circuit built in.
Rung scene_rung(const FieldRung&, std::string_view mechanics);

}  // namespace powbench::sim
