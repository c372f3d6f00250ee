#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/models/fields.h"

/// The kinds of mechanics, one file each. A new one is a file with a `Mechanics`, and a line in mechanics.cpp: help,
/// plans, `auto` and messages follow from it.

namespace powbench::sim {

struct Mechanics {
  std::string_view name;
  int detail;       ///< how much of the motion it has: those of equal number solve the same equations
  bool any_fields;  ///< false: with the circuit only, which is built in
  bool costly;      ///< minutes a closing
  std::string (*unknown)(const Case&);  ///< what of a case it does not model, one sentence, which its
                                        ///< rungs throw as std::invalid_argument; empty: nothing
  Rung (*rung)(const FieldRung&);
};

/// Cheap to costly.
std::span<const Mechanics> all_mechanics();
/// Throws std::invalid_argument for an unknown name.
const Mechanics& mechanics_named(std::string_view name);
/// Those that a choice may climb, with any fields, cheap ones first; `costly`: also those that take minutes.
std::vector<std::string> automatic_mechanics(const Case&, bool costly);
/// The cheapest that solves the same equations with these fields, and knows the case.
std::string_view cheapest_equal(std::string_view name, const FieldRung&, const Case&);

/// How far `deformable` goes: its times after the bounces are not reliable, and every ms costs a second.
inline constexpr double deformable_duration = 0.03;  // s

/// The pair as a rung. Settings: `plant` and `rigid` take tolerances, `modal` the share of its critical step,
/// `deformable` the edge of its cells in mm. Throws std::invalid_argument for an unknown name, and for mechanics that
/// do not take these fields.
Rung scene_rung(const FieldRung&, std::string_view mechanics);

/// A rung as a search calls it: at the tolerance it asks for, or at the finest of the rung's own settings. What cannot
/// be simulated has the empty truth, as if nothing closed: ask `Mechanics::unknown` before.
ClosingModel closing_model(const Rung&);

/// The pairs of the circuit with `plant` and `rigid`: the same equations, they differ by their integrators alone.
std::vector<Rung> closing_rungs();

}  // namespace powbench::sim
