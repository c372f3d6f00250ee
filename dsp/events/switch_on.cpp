#include "dsp/events/switch_on.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/signal/signal.h"

namespace powbench::dsp {

namespace {

constexpr double mean_span = 4e-3;    // s
constexpr double quiet_guard = 1e-3;  // s before time 0 that says nothing
constexpr double flows = 0.05;        // of the largest swing
constexpr double at_once = 0.33;      // of the largest mean, in a current's first samples
constexpr double not_yet = 0.02;      // of the largest mean
constexpr double noise_like = 0.7;    // difference of neighbours, of the values' rms
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Mean magnitude of the samples of [from, to), and their standard deviation; NaN where there are none.
struct SpanLevel {
  double mean = unknown, swing = unknown;
};
SpanLevel span_level(const Signal& s, double from, double to) {
  const std::size_t i1 = s.index_at(from), i2 = s.index_at(to);
  if (i2 <= i1) return {};
  double sum = 0, plain = 0, squares = 0;
  for (std::size_t i = i1; i < i2; ++i)
    sum += std::abs(s.value[i]), plain += s.value[i], squares += s.value[i] * s.value[i];
  const auto n = static_cast<double>(i2 - i1);
  return {sum / n, std::sqrt(std::max(squares / n - plain * plain / (n * n), 0.0))};
}

bool is_noise(const Signal& s) {
  double squares = 0, steps = 0;
  for (std::size_t i = 1; i < s.size(); ++i)
    squares += s.value[i] * s.value[i], steps += std::pow(s.value[i] - s.value[i - 1], 2);
  return !(steps < noise_like * noise_like * squares);
}

/// First time at which the swing over a quarter of the span reaches a twentieth of the largest.
double begin_of(const Signal& s, double largest) {
  for (double t = s.t0; t + 0.25 * mean_span < s.end(); t += 0.05 * mean_span)
    if (span_level(s, t, t + 0.25 * mean_span).swing > flows * largest)
      return t > s.t0 ? t + 0.25 * mean_span : -HUGE_VAL;
  return unknown;
}

}  // namespace

double contradicted_switch_on(const Record& record) {
  const bool voltage = record.find(Channel::coil_voltage) != nullptr;
  const Signal s = to_signal(record, voltage ? Channel::coil_voltage : Channel::coil_current);
  if (s.empty() || s.t0 > 0 || s.end() < 2 * mean_span || is_noise(s)) return unknown;
  SpanLevel largest{0, 0};
  for (double t = s.t0; t + mean_span <= s.end(); t += 0.5 * mean_span) {
    const SpanLevel here = span_level(s, t, t + mean_span);
    largest = {std::max(largest.mean, here.mean), std::max(largest.swing, here.swing)};
  }
  const bool before =
      span_level(s, std::max(s.t0, -quiet_guard - mean_span), -quiet_guard).swing > flows * largest.swing;
  const bool at_start =
      !voltage && s.t0 > -quiet_guard && span_level(s, 0, 20 * s.dt).mean > at_once * largest.mean;
  const bool late = span_level(s, 0, mean_span).mean < not_yet * largest.mean;
  return before || at_start || late ? begin_of(s, largest.swing) : unknown;
}

}  // namespace powbench::dsp
