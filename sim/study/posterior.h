#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/study/bounce_calibration.h"
#include "sim/study/misfit.h"
#include "sim/team.h"

/// Approximate posterior samples of a specimen's parameters, for predictions.
///
/// Touch and seat are smooth functions of every parameter; bounce is discontinuous. A global search of the whole
/// misfit therefore stalls a few standard deviations above the optimum of the smooth part. So the smooth part
/// (`Misfit::motion`) is minimised to convergence by least squares from several starts. Each posterior sample is then
/// the least-squares minimum with data and prior shifted at random by their deviations (exact for a linear model: J.
/// Bardsley et al., SIAM J. Sci. Comput. 36, 2014, A1895). The samples are not conditioned on measured bounce, nor on
/// the demands that are step functions (pick-up, absence of chatter): many samples violate one of these. Measured
/// bounce scales each sample by one factor and shows the error of its bounces.

namespace powbench::sim {

struct PosteriorOptions {
  long evaluations = 1'000;  ///< of the coarse search that the starts come from
  int starts = 3;            ///< of least squares, spread over what the coarse search ends with
  /// Further ones, one after the other, as long as the least sum of squares is above the number of measured values:
  /// then it is no fit, and another minimum is looked for.
  int further_starts = 9;
  int samples = 96;
  double tolerance = 1e-5;  ///< of the integrator in least squares
  std::uint64_t seed = 1;
};

struct Posterior {
  std::vector<std::vector<double>> samples;  ///< points, coordinates in [0, 1]
  BounceCalibration bounce;                  ///< by all closings of the misfit
  double misfit = 0;                         ///< least sum of squares of the motion
  std::vector<double> ends;  ///< sums of squares at the end of each start, ascending: one minimum or several
  bool stopped = false;      ///< `go_on` returned false: no result
};

/// `go_on` receives the share that is done and the best sum of squares so far. Reproducible for any number of threads.
Posterior sample_posterior(const Misfit&, const PosteriorOptions&, Team&,
                           const std::function<bool(double done, double best)>& go_on);

}  // namespace powbench::sim
