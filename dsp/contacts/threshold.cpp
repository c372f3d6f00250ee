#include "dsp/contacts/threshold.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "dsp/contacts/contact_train.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double most_smoothing = 12e-6;  // s

double smoothed_noise(double noise, double width, double dt) {
  return width > 0 ? noise * gaussian_noise_gain(width / dt) : noise;
}

/// Smoothing moves a low crossing on a hard pulse outwards: no more of it than the noise asks for.
double least_width(double level, double noise, double dt) {
  for (double width = 0; width<most_smoothing; width = width> 0 ? 1.5 * width : 1e-6)
    if (8 * smoothed_noise(noise, width, dt) <= level) return width;
  return most_smoothing;
}

void check(const ThresholdRule& r) {
  if (!(r.share > 0 && r.share < 1))
    throw std::invalid_argument("share = " + std::to_string(r.share) + ": allowed 0 .. 1, exclusive");
  if (!(r.min_open >= 0 && r.min_open < 1 && r.min_closed >= 0 && r.min_closed < 1))
    throw std::invalid_argument("min_open, min_closed: allowed 0 .. 1 s");
}

struct Level {
  const Signal& force;
  const std::vector<double>& smooth;
  double level, noise;

  Measured crossing(std::size_t i) const {
    const double rise = smooth[i] - smooth[i - 1];
    const double share = rise != 0 ? std::clamp((level - smooth[i - 1]) / rise, 0.0, 1.0) : 0.5;
    const double u = std::hypot(0.1, rise != 0 ? noise / std::abs(rise) : 1.0) * force.dt;
    return {force.time(i - 1) + share * force.dt, u};
  }
};

/// Where the level itself was passed, looking back from where the hysteresis was.
std::size_t passed(const Level& l, std::size_t i, bool up) {
  while (i > 1 && (l.smooth[i - 1] > l.level) == up) --i;
  return i;
}

std::vector<Contact> crossings(const Level& l, std::size_t last) {
  std::vector<Contact> out;
  const double guard = std::min(4 * l.noise, 0.5 * l.level);
  bool closed = false;
  for (std::size_t i = 1; i < last; ++i) {
    if (!closed && l.smooth[i] > l.level + guard) {
      closed = true;
      out.emplace_back();
      out.back().touch = l.crossing(passed(l, i, true));
    } else if (closed && l.smooth[i] < l.level - guard) {
      closed = false;
      out.back().release = l.crossing(passed(l, i, false));
    }
  }
  return out;
}

void apply_durations(std::vector<Contact>& contacts, const ThresholdRule& r) {
  std::vector<Contact> merged;
  for (const Contact& c : contacts) {
    if (!merged.empty() && c.touch.value - merged.back().release.value < r.min_open)
      merged.back().release = c.release;
    else
      merged.push_back(c);
  }
  std::erase_if(merged, [&](const Contact& c) {
    return c.release.known() && c.release.value - c.touch.value < r.min_closed;
  });
  contacts = std::move(merged);
}

void weigh(Contact& c, const Signal& s, double noise, double t_end) {
  const double end = c.release.known() ? c.release.value : t_end;
  double peak = 0, sum = 0, n = 0;
  for (std::size_t i = s.index_at(c.touch.value); i < s.index_at(end); ++i) {
    peak = std::max(peak, s.value[i]);
    sum += s.value[i] * s.dt;
    n += 1;
  }
  c.peak = {peak, noise};
  if (c.release.known()) c.impulse = {sum, noise * std::sqrt(n) * s.dt};
  const std::uint8_t mask = s.mask_within(c.touch.value, end);
  if (mask & mask_clipped) c.flags |= flag_clipped;
  if (mask & mask_gap) c.flags |= flag_gap;
}

}  // namespace

ContactTrain threshold_train(const Signal& force, double settled, double noise, double t_end,
                             const ThresholdRule& rule) {
  check(rule);
  ContactTrain t;
  if (force.empty()) return t;
  t.present = true;
  t.noise = noise;
  const double height = rule.share * settled, width = least_width(height, noise, force.dt);
  const auto smooth = width > 0 ? gaussian_smooth(force.value, width / force.dt) : force.value;
  const Level l{force, smooth, height, smoothed_noise(noise, width, force.dt)};
  t.resolution = std::max({rule.min_open, 4 * width, 3 * force.dt});
  if (!(l.level > 3 * l.noise)) {
    t.flags |= flag_poor_fit;
    return t;
  }
  t.contacts = crossings(l, force.index_at(t_end));
  apply_durations(t.contacts, rule);
  for (Contact& c : t.contacts) weigh(c, force, noise, t_end);
  t.settled_force = {settled, noise};
  summarise(t, 0.0);
  return t;
}

}  // namespace powbench::dsp
