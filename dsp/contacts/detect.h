#pragma once

#include <limits>
#include <vector>

#include "dsp/options.h"
#include "dsp/signal/signal.h"

/// Coarse contact detection on the wide-band restored force: two levels above the noise, no filter that could
/// overshoot.

namespace powbench::dsp {

struct DetectionLevels {
  double width = 0.0;       ///< s, standard deviation of the smoothing Gaussian
  double noise = 0.0;       ///< N, of the smoothed force
  double touch = 0.0;       ///< N, rising through it = closed
  double release = 0.0;     ///< N, falling through it = open
  double resolution = 0.0;  ///< s, shortest opening that two levels this close to zero can tell apart
};

/// `noise`: N, of one sample, white. `settled`: N, 0 when unknown.
DetectionLevels detection_levels(double noise, double dt, double settled, const ExtractOptions&);

/// The same at a given width, for noise that is not white: `smooth_noise` is the smoothed noise itself.
DetectionLevels levels_at_width(double width, double smooth_noise, double dt, double settled,
                                const ExtractOptions&);

/// A closed interval, by level crossing with linear interpolation.
struct Interval {
  double touch = 0.0;    ///< s
  double release = 0.0;  ///< s; infinity while it stays closed
  bool open_ended() const { return release == std::numeric_limits<double>::infinity(); }
};

struct Detection {
  std::vector<double> smooth;  ///< (n) the smoothed force
  std::vector<Interval> intervals;
};

/// Contacts between t1 and t2. Closed at t2 = open-ended.
Detection detect_contacts(const Signal& force, const DetectionLevels&, double t1, double t2,
                          const ExtractOptions&);

}  // namespace powbench::dsp
