#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/study/bounce_calibration.h"
#include "sim/study/misfit.h"
#include "sim/team.h"

/// What measured closings leave open about a specimen, as a sample: for predictions.
///
/// Touch and seat move smoothly with every number of a specimen, bounce jumps. A global search of the whole misfit ends within a few
/// deviations of the smooth part and stays there, for the jumps hide what is left. So the smooth part (`Misfit::motion`) is taken to its
/// end, by least squares from several starts; then draws of its posterior are made by least squares too, each with data and prior
/// shifted at random by their deviations (exact where the model is linear: J. Bardsley et al., SIAM J. Sci. Comput. 36, 2014,
/// A1895). Measured bounce moves no draw, nor do the steps among what the kind demands, pick-up and absence of chatter: many draws fail
/// one of them. Bounce tells one factor of each draw, and how far the draws' bounces are off.

namespace powbench::sim {

struct PosteriorOptions {
  long evaluations = 1'000;  ///< of the coarse search that the starts come from
  int starts = 3;            ///< of least squares, spread over what the coarse search ends with
  int draws = 96;
  double tolerance = 1e-5;  ///< of the integrator in least squares
  std::uint64_t seed = 1;
};

struct Posterior {
  std::vector<std::vector<double>> draws;  ///< points, coordinates in [0, 1]
  BounceCalibration bounce;                ///< by all closings of the misfit
  double misfit = 0;                       ///< least sum of squares of the motion
  std::vector<double> ends;  ///< sums that the starts ended with, ascending: one basin or several
  bool stopped = false;      ///< `go_on` said so: nothing to use
};

/// `go_on` is given the share that is done and the best sum of squares so far. Reproducible for any number of threads.
Posterior sample_posterior(const Misfit&, const PosteriorOptions&, Team&,
                           const std::function<bool(double done, double best)>& go_on);

}  // namespace powbench::sim
