#include "dsp/contacts/ring_tail.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dsp/contacts/joint_fit.h"

namespace powbench::dsp {

Ring ring_from_tail(const Force& f, const Round& r, double t_end, const ExtractOptions& o) {
  if (!r.intervals.back().open_ended()) return {};
  const std::vector<std::uint8_t> usable(f.signal.size(), 1);
  constexpr double last_wait = 2.5e-3, still_moving = 8;  // s; reduced sum of squares
  Ring best;
  for (const double wait : {150e-6, 1.2e-3, last_wait}) {
    const double from = r.intervals.back().touch + wait, to = std::min(from + o.ring_tail, t_end);
    const RingInput in{f.signal, usable, from, from, to, f.noise};
    double reduced = 0;
    // the contact still moves where the poles seen cannot explain the tail: later, not with more modes
    best = grow_ring(in, tail_poles(in, o), o, &reduced,
                     wait < last_wait ? still_moving : std::numeric_limits<double>::infinity());
    if (!best.empty() && reduced < 1.5) break;
  }
  return best;
}

Ring ring_at_rest(const Force& f, double touch, double t_end, const ExtractOptions& o) {
  constexpr double shortest = 1e-3;  // s: less tells no modes apart
  const double from = touch + joint_rest, to = std::min(touch + o.ring_tail, t_end);
  if (!(to > from + shortest)) return {};
  const std::vector<std::uint8_t> usable(f.signal.size(), 1);
  const RingInput in{f.signal, usable, from, from, to, f.noise};
  return grow_ring(in, tail_poles(in, o), o);
}

bool same_vibration(const Ring& ring, const Ring& other) {
  const auto size = [&](const RingMode& m) {
    return std::hypot(m.cosine, m.sine) * std::exp(-m.pole.decay * (ring.onset - ring.reference));
  };
  const auto main = std::max_element(ring.modes.begin(), ring.modes.end(),
                                     [&](const RingMode& a, const RingMode& b) { return size(a) < size(b); });
  return main != ring.modes.end() &&
         std::any_of(other.modes.begin(), other.modes.end(), [&](const RingMode& m) {
           return std::abs(m.pole.hertz - main->pole.hertz) < 0.1 * main->pole.hertz;
         });
}

}  // namespace powbench::dsp
