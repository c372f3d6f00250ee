#pragma once

#include <optional>
#include <vector>

#include "core/events.h"
#include "dsp/signal/signal.h"

/// Mains fundamental and harmonics by least squares: the hum on a force channel, the phase of the supply.

namespace powbench::dsp {

/// v(t) = offset + sum_k cosine[k] cos(n_k w (t - centre)) + sine[k] sin(n_k w (t - centre)), w = 2 pi hertz.
struct HarmonicFit {
  double hertz = 0.0;
  double u_hertz = 0.0;  ///< 0 when the frequency was given
  double centre = 0.0;   ///< s
  double offset = 0.0;
  std::vector<int> order;  ///< n_k
  std::vector<double> cosine, sine;
  std::vector<double>
      covariance;  ///< (p, p) of offset, cosine[0], sine[0], cosine[1], ..., [w]; residual variance included
  std::size_t parameters = 0;
  double sigma = 0.0;  ///< rms of the residual (of block means, see fit_harmonics)

  double value(double t) const;
  /// s - v at every sample; a few hundred units of the last place of each amplitude from `value`, at a tenth of its
  /// cost.
  void subtract_from(Signal& s) const;
  double amplitude(std::size_t k) const;
  /// Phase of the sine-referenced fundamental at t: v = A sin(phase). [0, 2 pi), with its standard
  /// uncertainty.
  Measured phase_at(double t) const;
};

/// Fit over samples with t1 <= time < t2 that are not masked; samples are averaged in blocks of 50 us first
/// (the blocks' frequency response is divided out). With `fit_frequency` the frequency is a parameter too
/// (IEEE 1057 four- parameter fit extended by harmonics, Gauss-Newton from `hertz`). Nothing when the window
/// holds fewer than `min_periods` periods or fewer than twice as many blocks as parameters.
std::optional<HarmonicFit> fit_harmonics(const Signal&, double t1, double t2, std::vector<int> orders,
                                         double hertz, bool fit_frequency, double min_periods);

}  // namespace powbench::dsp
