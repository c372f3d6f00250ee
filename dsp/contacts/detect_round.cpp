#include "dsp/contacts/detect_round.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "dsp/signal/statistics.h"
#include "dsp/vibration/ring.h"

namespace powbench::dsp {

namespace {

/// Standard deviation of x where `open`, between the first touch and the last: robust, or with `bursts` the plain
/// one, in which a ring that dies quickly counts in full.
double open_sigma(std::span<const double> x, const std::vector<std::uint8_t>& open, const Signal& s,
                  const Detection& d, bool bursts = false) {
  if (d.intervals.empty()) return 0.0;
  const double end = d.intervals.back().open_ended() ? d.intervals.back().touch : d.intervals.back().release;
  std::vector<double> left;
  for (std::size_t i = s.index_at(d.intervals.front().touch); i < s.index_at(end); ++i)
    if (open[i] && !s.masked[i]) left.push_back(x[i]);
  if (left.size() < 30) return 0.0;
  if (!bursts) return robust_sigma(left);
  double squares = 0;
  for (const double v : left) squares += v * v;
  return std::sqrt(squares / static_cast<double>(left.size()));
}

/// 1 where the force averages to zero: open, whatever rings on top. Gaussian mean of 80 us, or with `both_means` of
/// 200 us too (it also cancels slow modes), below `open_level`, 120 us clear of any other force.
std::vector<std::uint8_t> zero_on_average(const Signal& force, double open_level, bool both_means) {
  std::vector<std::uint8_t> open(force.size());
  const auto guard = static_cast<std::size_t>(120e-6 / force.dt);  // a contact's own foot is not open time
  // The longer mean also cancels slow modes, the shorter one also sees short openings.
  for (const auto& [width, level] : {std::pair(80e-6, open_level), std::pair(200e-6, open_level)}) {
    if (width > 100e-6 && !both_means) break;
    const auto mean = bell_mean(force.value, width / force.dt);
    std::size_t run = 0;  // samples since the mean last left zero
    for (std::size_t i = 0; i <= open.size(); ++i) {
      if (i < open.size() && std::abs(mean[i]) < level) {
        ++run;
        continue;
      }
      for (std::size_t k = i - run + guard; k + guard < i; ++k) open[k] = 1;
      run = 0;
    }
  }
  return open;
}

constexpr double wide = 30e-6;  ///< s: removes 15 kHz, keeps openings of 0.12 ms

Round with(Round r, Detection d, const Signal& force) {
  r.intervals = std::move(d.intervals);
  r.smooth = std::move(d.smooth);
  r.t0 = force.t0;
  r.dt = force.dt;
  return r;
}

}  // namespace

double Round::smooth_peak(double t1, double t2) const {
  double top = 0;
  const double n = static_cast<double>(smooth.size());
  const double i1 = std::clamp(std::ceil((t1 - t0) / dt), 0.0, n), i2 = std::clamp((t2 - t0) / dt, i1, n);
  for (auto i = static_cast<std::size_t>(i1); i < static_cast<std::size_t>(i2); ++i)
    top = std::max(top, smooth[i]);
  return top;
}

Round detect_wide(const Signal& force, double noise, double settled, double t_end, const ExtractOptions& o) {
  Round r;
  r.noise = noise;
  r.levels = levels_at_width(wide, 3 * noise * gaussian_noise_gain(wide / force.dt), force.dt, settled, o);
  Detection d = detect_contacts(force, r.levels, force.t0 + 5 * wide, t_end, o);
  return with(std::move(r), std::move(d), force);
}

Round detect_round(const Signal& force, double noise, double settled, double t_end, const ExtractOptions& o,
                   bool final_round) {
  Round r;
  r.noise = noise;
  r.levels = detection_levels(noise, force.dt, settled, o);
  const double begin = force.t0 + 5 * r.levels.width;
  Detection d = detect_contacts(force, r.levels, begin, t_end, o);
  const auto open = zero_on_average(force, std::max(0.1 * settled, r.levels.release), final_round);
  const double narrow_sigma = open_sigma(d.smooth, open, force, d);
  if (r.levels.width < wide && narrow_sigma > 2.5 * r.levels.noise) {
    const double white = noise * gaussian_noise_gain(wide / force.dt);
    const auto smooth = gaussian_smooth(force.value, wide / force.dt);
    const double sigma = std::max(white, open_sigma(smooth, open, force, d));
    if (sigma < narrow_sigma / 4) {
      r.levels = levels_at_width(wide, sigma, force.dt, settled, o);
      r.noise = std::max(noise, open_sigma(force.value, open, force, d));
      d = detect_contacts(force, r.levels, begin, t_end, o);
    }
  }
  // A decaying ring is half again as large at its start as its median says.
  const double rest = final_round ? std::max(1.5 * open_sigma(d.smooth, open, force, d),
                                             open_sigma(d.smooth, open, force, d, true))
                                  : 0.0;
  if (rest > 2.5 * r.levels.noise && 4 * rest > r.levels.touch) {
    // Vibration that could not be taken out: the levels rise above it, and the train says so.
    r.levels =
        levels_at_width(r.levels.width, std::min(0.7 * rest, 0.5 * settled / o.touch_sigmas + r.levels.noise),
                        force.dt, settled, o);
    r.noise = std::max(r.noise, open_sigma(force.value, open, force, d));
    r.overlap = true;
    d = detect_contacts(force, r.levels, begin, t_end, o);
  }
  return with(std::move(r), std::move(d), force);
}

}  // namespace powbench::dsp
