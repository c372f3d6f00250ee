#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/conditions.h"
#include "sim/models/closing.h"
#include "sim/specimen/specimen.h"
#include "sim/supply/supply_modes.h"

/// What is simulated, and one way to do it.

namespace powbench::sim {

/// A specimen, the conditions it is closed under and what feeds it: of `bench`, volts, hertz and phase are the
/// conditions'.
struct Case {
  Specimen specimen;
  Conditions conditions;
  Supply bench{};
};

/// One way to simulate a closing, to be had at any tolerance - or, where `settings` says so, at any step or cell.
struct Rung {
  std::string fields;     ///< magnetics, e.g. `circuit`
  std::string mechanics;  ///< motion, e.g. `rigid`
  std::string meaning;    ///< one line
  /// case, s simulated, relative tolerance of the integrator or other setting, s between samples (0: none)
  std::function<Trajectory(const Case&, double duration, double tolerance, double sample_dt)> run;
  std::string setting = "tolerance";  ///< what the third argument is
  std::vector<double> settings =
      {};               ///< coarse to fine, the last is what counts as true; empty: any tolerance
  bool costly = false;  ///< seconds a closing

  std::string name() const { return fields + "+" + mechanics; }
};

}  // namespace powbench::sim
