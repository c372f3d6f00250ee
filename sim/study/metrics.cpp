#include "sim/study/metrics.h"

#include <algorithm>

#include "sim/models/closing.h"

namespace powbench::sim {

const MetricInfo* find_metric(std::string_view name) {
  for (const auto& m : metric_table)
    if (m.name == name) return &m;
  return nullptr;
}

ClosingMetrics closing_metrics(const ClosingTruth& t) {
  ClosingMetrics m;
  if (!t.touch || !t.core_seat || t.calm == 0) return m;
  m.closed = 1;
  m.touch = *t.touch;
  m.settled = *t.settled;
  m.bounce = m.settled - m.touch;
  m.seat = *t.core_seat;
  m.openings = static_cast<double>(t.openings.size());
  m.open_time = 0;
  for (const auto& o : t.openings) m.open_time += o.touch - o.release;
  m.touch_velocity = t.touch_velocity;
  m.seat_velocity = t.seat_velocity;
  return m;
}

ClosingMetrics closing_metrics(const Case& c, const MetricOptions& options) {
  const Trajectory run =
      simulate(c.specimen, c.conditions, options.duration, options.sample_dt, options.tolerance, c.bench);
  const ClosingTruth& t = run.truth;
  ClosingMetrics m = closing_metrics(t);
  if (m.closed == 0 || run.samples.empty()) return m;
  const double first_end = t.openings.empty() ? options.duration : t.openings.front().release;
  m.first_peak = m.impulse = 0;
  for (const auto& s : run.samples) {
    if (s.time < m.touch) continue;
    if (s.time <= first_end) m.first_peak = std::max(m.first_peak, s.force_a);
    if (s.time <= m.settled) m.impulse += s.force_a * options.sample_dt;
  }
  return m;
}

}  // namespace powbench::sim
