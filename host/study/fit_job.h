#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/store/points.h"
#include "host/study/fit_file.h"
#include "host/study/problem.h"
#include "sim/study/fit.h"
#include "sim/study/posterior.h"

/// A whole identification. To describe: a fit to all closings (sim/study/fit.h). To predict angles that it must not
/// see: a posterior of the others (sim/study/posterior.h).

namespace powbench::host {

struct FitJob {
  sim::FitProblem problem;          ///< with every closing that may be used at all
  std::vector<double> held_out;     ///< rad; a posterior for each, which does not see it
  std::vector<double> unseen;       ///< rad; not among the closings: one posterior of them all predicts these
  sim::PosteriorOptions posterior;  ///< the seed is that of `options`
  /// Bounds of the posteriors: the names of `problem`, in the same order. Empty: those of `problem`.
  std::vector<sim::Parameter> posterior_parameters;
  sim::FitOptions options;  ///< of every search of the fit to all; `evaluations` each
  int searches = 3;         ///< independent ones: their members together are its ensemble
  /// Above 0 the fit to everything describes: no prior, deviations half of what is wanted on average (2 % of touch
  /// and seat, 8 % of bounce, 3 % of settled), so many evaluations of each of its searches, and as many of a last
  /// one, from what the others found, on the sum of absolute deviations.
  long finish = 0;
  int next = 0;                            ///< measurements to propose, from a posterior of all closings
  ModelDeviation granted{};                ///< of one closing of these measurements
  ShotScatter scatter{};                   ///< of single shots, where repeats tell it
  std::vector<std::vector<double>> start;  ///< points that the searches begin from; posteriors have none
};

struct FitReport {
  FitFile file;
  std::optional<FitFold> posterior{};  ///< of all closings, where `next` asks for it
  sim::FitResult full;                 ///< the fit to everything
  bool stopped = false;                ///< `watch` said so: the state to go on from is in `state`
  bool part = false;                   ///< only some of the points were wanted: nothing else is filled
  FitState state;
};

/// After each generation: which search of how many, evaluations used of how many, best so far. False: stop.
using FitProgress =
    std::function<bool(std::size_t fit, std::size_t fits, long used, long of, double best, const FitState&)>;

/// Posteriors, which come first; the searches and, with `finish`, the last one follow.
std::size_t blind_fits(const FitJob&);

/// Hash of everything that the result depends on.
std::string problem_hash(const FitJob&);

/// Runs the fits in order; goes on from `state` when its problem is this one.
/// Throws BadInput when it belongs to another. Posteriors and searches, the last one left out because it begins from
/// what the others found, are points: what `points` knows is not computed.
FitReport run_fits(const FitJob&, sim::Team&, const FitProgress&, const FitState&, Points& points);

}  // namespace powbench::host
