#include "dsp/contacts/joint_ring.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"

namespace powbench::dsp {

bool bounded(const Ring& ring, double limit) {
  return std::all_of(ring.modes.begin(), ring.modes.end(), [&](const RingMode& m) {
    return std::hypot(m.cosine, m.sine) * std::exp(-m.pole.decay * (ring.onset - ring.reference)) < limit;
  });
}

void add_modes(const JointInput& in, JointModel& m, double limit) {
  JointInput trial = in;  // whether a mode is worth it shows long before its parameters are final
  trial.enough = 1;
  trial.judged = true;
  while (static_cast<int>(m.ring.modes.size()) < in.options.ring_modes) {
    const JointResidual left = joint_residual(in, m);
    const double to = left.signal.end();
    const auto more =
        strongest_pole({left.signal, left.usable, m.ring.onset, to, to, left.noise}, {}, in.options);
    if (!more) return;
    JointModel next = m;
    next.ring.modes.push_back({*more, 0.0, 0.0});
    next = fit_joint(trial, std::move(next), 6);
    if (!(next.chi2 < m.chi2 - 40 * std::max(1.0, m.reduced())) || !bounded(next.ring, limit)) return;
    m = std::move(next);
  }
}

bool seed_ring(const JointInput& in, JointModel& m, double from, double to) {
  const JointResidual left = joint_residual(in, m);
  double best = 0;
  for (double t = from; t < to; t += 0.2e-3) {
    const double end = std::min(t + 2.5e-3, left.signal.end());
    double gain = 0;
    const auto pole =
        strongest_pole({left.signal, left.usable, t, end, end, left.noise}, {}, in.options, &gain);
    if (!pole || gain <= best) continue;
    Ring ring = fit_ring({left.signal, left.usable, t, end, end, left.noise}, {*pole}, in.options);
    if (ring.empty()) continue;
    best = gain;
    m.ring = std::move(ring);
  }
  return best > 0;
}

void drop_stand_ins(const JointInput& in, JointModel& m) {
  constexpr double beside_before = 60e-6, beside_after = 150e-6, longest = 0.25e-3, far = 2e-3;  // s
  constexpr double crest = 2, half_period = 0.6;
  for (std::size_t k = 0; k < m.pulses.size(); ++k) {
    const PulseShape f = m.pulses[k].shape;
    const double t = m.ring.onset, width = f.release - f.touch;
    const bool beside = width < longest && t > f.touch - beside_before && t < f.release + beside_after;
    const bool swing = t < f.release + far && width < half_period * m.ring.longest_period() &&
                       f.peak < crest * m.ring.amplitude_at(std::max(f.touch, t));
    if (!beside && !swing) continue;
    JointModel without = m;
    without.pulses.erase(without.pulses.begin() + static_cast<std::ptrdiff_t>(k));
    JointInput wide = in;
    if (beside || t > f.touch) {
      without.ring.onset = f.touch;
      wide.onset_from = std::min(in.onset_from, f.touch - 100e-6);
      wide.onset_to = std::max(in.onset_to, f.release + 100e-6);
    }
    without = fit_joint(wide, std::move(without), 8);
    if (!(without.cost() < m.cost() + (beside ? 10 : 0))) continue;
    m = std::move(without);
    --k;
  }
}

void drop_ring_pieces(const JointInput& in, JointModel& m) {
  for (std::size_t k = m.pulses.size(); k-- > 0;) {
    const PulseShape f = m.pulses[k].shape;
    if (!(f.peak < m.ring.amplitude_at(f.touch))) continue;
    JointModel without = m;
    without.pulses.erase(without.pulses.begin() + static_cast<std::ptrdiff_t>(k));
    without = fit_joint(in, std::move(without), 8);
    if (without.cost() < m.cost()) m = std::move(without);
  }
}

void keep_within_limits(const JointInput& in, JointModel& m) {
  const auto outside = [&](const RingMode& mode) {
    return mode.pole.hertz < in.options.ring_low_hertz ||
           mode.pole.decay > in.options.ring_damping_max * 2 * pi * mode.pole.hertz;
  };
  while (std::erase_if(m.ring.modes, outside) > 0)
    if (!m.ring.empty()) m = fit_joint(in, std::move(m), 8);
}

}  // namespace powbench::dsp
