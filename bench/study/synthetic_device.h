#pragma once

#include <vector>

#include "core/random.h"
#include "sim/specimen/specimen.h"

/// Devices whose closings a study measures, and what instruments see of one closing.

namespace powbench::bench {

/// What is measured of one closing. SI; NaN where it did not close.
struct Shot {
  double angle = 0;  ///< rad, commanded
  double touch, bounce, seat, core_settled;
  double touch_speed, seat_speed;  ///< m/s: contact against contact, core against stop
  double force_peak;  ///< N, both breaks of the measured bridge, in the 0.5 ms after the first touch
  bool closed = false;
};

enum class Model {
  fitted,  ///< the one that is fitted
  other  ///< Hertzian contacts and stop, core that tilts, static core on its buffer, housing that bends, unequal gaps,
  ///< iron of another law with a coercive field: none of it free in the fit
};

struct Device {
  sim::Specimen specimen;
  Model model = Model::fitted;
};

/// One closing at exact conditions, 50 Hz. Without `force` the peak is NaN and costs nothing.
Shot closing(const Device&, double angle, double volts, double duration, double tolerance, bool force);

/// A device over the catalogue's bounds, uniform in each number; drawn again until it keeps the ranges of its
/// kind (inrush, holding, overtravel, contact force, mounting), picks up at 0.85 of 230 V, and at every 15 deg
/// settles within 26 ms, the median bounce of these between 2 and 12 ms. `tried`: counts the draws.
Device drawn_device(Random&, Model, long& tried);

/// As an instrument prints it: mains within 1 % and the angle within 1 deg of what was asked for (uniform; the
/// fit knows neither), 0.05 ms of every time, 2 % of speeds, 5 % of the force.
Shot measured(const Device&, double angle, Random&);

/// Median of every quantity over repeats.
Shot median_shot(const std::vector<Shot>&);

double median_of(std::vector<double>);

}  // namespace powbench::bench
