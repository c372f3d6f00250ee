#include "dsp/contacts/joint_start.h"

#include <algorithm>
#include <cmath>

namespace powbench::dsp {

JointModel start_of(const Round& r, double settled, const JointModel& before) {
  JointModel m;
  m.ring = before.ring;
  m.pedestal = before.pedestal;
  for (const Interval& c : r.intervals) {
    if (c.open_ended()) {
      m.rise = before.rise && before.rise->modelled && std::abs(before.rise->touch - c.touch) < 200e-6
                   ? *before.rise
                   : JointRise{.touch = c.touch, .rise = 2e-4, .modelled = true, .linear = {settled}};
      continue;
    }
    JointPulse p;
    const auto same = std::find_if(before.pulses.begin(), before.pulses.end(), [&](const JointPulse& q) {
      return std::abs(q.shape.touch - c.touch) + std::abs(q.shape.release - c.release) < 80e-6;
    });
    if (same != before.pulses.end() && same->modelled) {
      p = *same;
    } else {
      const double top = r.smooth_peak(c.touch, c.release);
      p.shape = {c.touch, c.release, std::max(top, r.levels.touch), 1.2, 1.0};
    }
    m.pulses.push_back(p);
  }
  return m;
}

}  // namespace powbench::dsp
