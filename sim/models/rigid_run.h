#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sim/mechanics/rigid_contactor.h"
#include "sim/models/stages.h"

/// One closing on the rigid rung: stages by name, the energy ledger, and a stop when the ledger does not close.

namespace powbench::sim {

/// The stages reached, from the events of a closing of `bridges` bridges up to `end` s; `closed` only where the last
/// bounce is at least `calm` s before the end.
std::vector<StageTime> closing_stages(std::span<const RigidEvent>, int bridges, double end,
                                      double calm = 2e-3);

struct RigidOptions {
  double tolerance = 1e-8;     ///< per state scale, 1e-13 .. 1e-3
  double end = 0.06;           ///< s
  double largest_step = 1e-3;  ///< s
  bool ledger = true;
  bool stiff_fallback = true;  ///< settled phases that are stiff go to the Rosenbrock method
  /// Largest allowed residual of the ledger, and of what friction gives; 0: a hundred tolerances, at least 1e-6.
  double energy_bound = 0;
  double off = 1e300;  ///< s, the coil's switch is told to open: it does at the next zero of the current
  double sample = 0;   ///< s between samples, 0: none
  /// Called at k * sample, k = 1, 2, ..., with the contactor and its states.
  std::function<void(double, const RigidContactor<double>&, const double*)> each;
};

struct RigidRun {
  std::vector<RigidEvent> events;
  std::vector<StageTime> stages;
  EnergyLedger energies;
  double energy_residual = 0;  ///< largest seen, looked at every eighth step
  std::int64_t evaluations = 0;
  std::int64_t steps = 0;
  std::int64_t stiff_steps = 0;  ///< of them by the fall-back
  double reached = 0;            ///< s
  bool completed = false;
  std::string dump;  ///< why and where it stopped, with states and ledger; empty when completed
};

/// Closes from static equilibrium. Throws std::invalid_argument for impossible parts or options. A run whose ledger
/// passes its bound, whose friction drives, or whose step becomes too small ends with a dump instead of a result.
RigidRun run_rigid(const RigidParts&, const CoilDrive&, const RigidOptions&);

}  // namespace powbench::sim
