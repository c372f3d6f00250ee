#include "sim/study/voltage_limits.h"

#include <algorithm>
#include <stdexcept>

namespace powbench::sim {
namespace {

/// The share of the voltage at which `stays` turns from false to true.
template <class Stays>
double turning_share(const Stays& stays, double resolution) {
  if (!(resolution > 1e-9 && resolution < 1))
    throw std::invalid_argument("resolution: allowed above 1e-9, below 1");
  if (!stays(1.0))
    throw std::invalid_argument(
        "supply_volts: the contactor does not close at this voltage, allowed one at which it does");
  double low = 0, high = 1;
  while (high - low > resolution) {
    const double middle = 0.5 * (low + high);
    (stays(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace

bool stays_closed(const ClosingTruth& t, const Conditions& c) {
  constexpr double periods = 2;
  return t.calm >= periods / c.mains_hertz;
}

double pick_up_volts(const Specimen& specimen, const Conditions& rated, const VoltageOptions& o) {
  const auto stays = [&](double share) {
    Conditions c = rated;
    c.supply_volts *= share;
    c.hold_time = o.wait;
    for (int k = 0; k < o.angles; ++k) {
      c.closing_angle = pi * k / o.angles;
      if (!stays_closed(simulate(specimen, c, o.wait, 0, o.tolerance).truth, c)) return false;
    }
    return true;
  };
  return rated.supply_volts * turning_share(stays, o.resolution);
}

double drop_out_volts(const Specimen& specimen, const Conditions& rated, const VoltageOptions& o) {
  const auto stays = [&](double share) {
    Conditions c = rated;
    c.hold_time = 2 * o.wait;
    Supply falling;
    falling.mains.dips[0] = {o.wait, 10 * o.wait, 1 - share, 0};
    const auto truth = simulate(specimen, c, c.hold_time, 0, o.tolerance, falling).truth;
    return truth.calm >= o.wait;
  };
  return rated.supply_volts * turning_share(stays, o.resolution);
}

}  // namespace powbench::sim
