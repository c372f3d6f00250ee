#include "dsp/contacts/detect.h"

#include <algorithm>
#include <cmath>

#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

double crossing(const Signal& s, const std::vector<double>& y, std::size_t i, double level) {
  if (i == 0) return s.time(0);
  const double rise = y[i] - y[i - 1];
  const double share = rise != 0 ? std::clamp((level - y[i - 1]) / rise, 0.0, 1.0) : 1.0;
  return s.time(i - 1) + share * s.dt;
}

/// Openings too short to be resolved are closed, contacts too short to be real are dropped.
std::vector<Interval> tidy(const std::vector<Interval>& raw, const ExtractOptions& o, double resolution) {
  std::vector<Interval> merged;
  for (const Interval& c : raw) {
    if (!merged.empty() && c.touch - merged.back().release < std::min(o.min_open, resolution))
      merged.back().release = c.release;
    else
      merged.push_back(c);
  }
  std::erase_if(merged, [&](const Interval& c) { return c.release - c.touch < o.min_closed; });
  return merged;
}

}  // namespace

DetectionLevels levels_at_width(double width, double smooth_noise, double dt, double settled,
                                const ExtractOptions& o) {
  DetectionLevels l;
  l.width = width;
  l.noise = smooth_noise;
  l.touch = std::max(o.touch_sigmas * l.noise, o.touch_share * settled);
  l.release = std::max(o.release_sigmas * l.noise, o.release_share * settled);
  l.resolution = std::max({4 * l.width, 3 * dt, o.min_open});
  return l;
}

DetectionLevels detection_levels(double noise, double dt, double settled, const ExtractOptions& o) {
  double width = o.detection_width;
  for (;;) {
    const double smooth_noise = noise * gaussian_noise_gain(width / dt);
    if (o.touch_sigmas * smooth_noise <= 0.25 * settled || width >= o.detection_width_max)
      return levels_at_width(width, smooth_noise, dt, settled, o);
    width = std::min(width * 1.25, o.detection_width_max);
  }
}

Detection detect_contacts(const Signal& force, const DetectionLevels& l, double t1, double t2,
                          const ExtractOptions& o) {
  Detection d;
  d.smooth = gaussian_smooth(force.value, l.width / force.dt);
  const std::size_t first = force.index_at(t1), last = force.index_at(t2);
  std::vector<Interval> raw;
  bool closed = false;
  for (std::size_t i = first; i < last; ++i) {
    if (!closed && d.smooth[i] > l.touch) {
      closed = true;
      // The force left zero where it last was below the release level, on the way up.
      std::size_t k = i;
      while (k > first && d.smooth[k - 1] > l.release) --k;
      const double at = raw.empty() ? -1e300 : raw.back().release;
      raw.push_back(
          {std::max(crossing(force, d.smooth, k, l.release), at), std::numeric_limits<double>::infinity()});
    } else if (closed && d.smooth[i] < l.release) {
      closed = false;
      raw.back().release = crossing(force, d.smooth, i, l.release);
    }
  }
  d.intervals = tidy(raw, o, l.resolution);
  return d;
}

}  // namespace powbench::dsp
