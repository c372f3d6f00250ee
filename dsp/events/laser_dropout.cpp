#include "dsp/events/laser_dropout.h"

#include <algorithm>
#include <cmath>

#include "dsp/signal/statistics.h"

namespace powbench::dsp {

std::vector<Dropout> laser_dropouts(const Signal& s, const LaserFlight& flight, double step) {
  constexpr double shortest = 0.3e-3;                    // s
  constexpr double least_of_travel = 0.02, ends = 0.05;  // of the travel
  struct Run {
    std::size_t from, to;
    bool moving;  // shows a value of mid-travel
  };
  const double jump = std::max({least_of_travel * flight.travel, 8 * flight.noise, 5 * std::abs(step)});
  std::vector<Run> jumped;
  std::vector<double> usual;  // samples for which a value of mid-travel is held
  for (std::size_t i = flight.first, from = i; i < flight.last; ++i) {
    if (s.value[i] == s.value[from]) continue;
    const double share = (s.value[from] - flight.open) / flight.travel;
    const bool moving = share > ends && share < 1 - ends;
    if (moving) usual.push_back(static_cast<double>(i - from));
    if (std::abs(s.value[i] - s.value[from]) > jump) jumped.push_back({from, i, moving});
    from = i;
  }
  const double held = usual.empty() ? 1 : median(usual);
  std::vector<Dropout> out;
  for (const Run& r : jumped) {
    const auto length = static_cast<double>(r.to - r.from);
    if (length * s.dt < shortest || length < 3 * held) continue;
    if (!r.moving && held > 3) continue;  // a slow laser that was at rest shows its first step so
    out.push_back({s.time(r.from), s.time(r.to)});
  }
  return out;
}

}  // namespace powbench::dsp
