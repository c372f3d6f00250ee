#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/study/fit_file.h"
#include "sim/study/fit.h"

/// A whole identification: all closings, then without each one of some angles in turn.

namespace powbench::host {

struct FitJob {
  sim::FitProblem problem;       ///< with every closing that may be used at all
  std::vector<double> held_out;  ///< rad; one more fit for each, which does not see it
  sim::FitOptions options;       ///< of every search; `evaluations` each
  int searches = 3;              ///< independent ones for every fit: their members together are its ensemble
  /// Above 0 the fit to everything describes: no prior, deviations half of what is wanted on average (2 % of touch and seat, 8 % of
  /// bounce, 3 % of settled), so many evaluations of each of its searches, and as many of a last one, from what the others found, on the sum of absolute
  /// deviations. The fits that hold an angle out are made to predict and have none of this.
  long finish = 0;
  std::vector<std::vector<double>>
      start;  ///< points that searches begin from; none for the ones that hold out
};

struct FitReport {
  FitFile file;
  sim::FitResult full;   ///< the fit to everything
  bool stopped = false;  ///< `watch` said so: the state to go on from is in `state`
  FitState state;
};

/// After each generation: which search of how many, evaluations used of how many, best so far. False: stop.
using FitProgress =
    std::function<bool(std::size_t fit, std::size_t fits, long used, long of, double best, const FitState&)>;

/// Hash of everything that the result depends on.
std::string problem_hash(const FitJob&);

/// Runs the fits in order; goes on from `state` when its problem is this one.
/// Throws BadInput when it belongs to another.
FitReport run_fits(const FitJob&, sim::Team&, const FitProgress&, const FitState& state = {});

}  // namespace powbench::host
