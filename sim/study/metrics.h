#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "sim/models/closing.h"
#include "sim/study/axis.h"

/// One closing in a few numbers.

namespace powbench::sim {

/// Metrics of a closing. All but `closed` are NaN when it does not close. SI.
struct ClosingMetrics {
  double closed = 0;  ///< 1: the core arrived at its stop, and the pole is closed at the end
  double touch = nan, bounce = nan, settled = nan, seat = nan;  ///< s
  double openings = nan;                                        ///< re-openings of the measured pole
  double open_time = nan;       ///< s open between first touch and settled: how long it would arc
  double touch_velocity = nan;  ///< m/s
  double seat_velocity = nan;   ///< m/s
  double first_peak = nan;      ///< N, one break, during the first touch
  double impulse = nan;         ///< N s, one break, first touch to settled
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
};

/// How metrics are printed, stored and named in options.
struct MetricInfo {
  std::string_view name;
  std::string_view unit;  ///< shown
  double per_si;          ///< shown value over SI
  std::string_view meaning;
  double ClosingMetrics::*member;
};
inline constexpr std::array metric_table{
    MetricInfo{"closed", "-", 1, "share that closes", &ClosingMetrics::closed},
    MetricInfo{"touch", "ms", 1e3, "first contact touch", &ClosingMetrics::touch},
    MetricInfo{"bounce", "ms", 1e3, "contact bounce time", &ClosingMetrics::bounce},
    MetricInfo{"settled", "ms", 1e3, "last touch", &ClosingMetrics::settled},
    MetricInfo{"seat", "ms", 1e3, "core arrives", &ClosingMetrics::seat},
    MetricInfo{"openings", "-", 1, "re-openings", &ClosingMetrics::openings},
    MetricInfo{"open_time", "ms", 1e3, "open between first touch and settled: wear",
               &ClosingMetrics::open_time},
    MetricInfo{"touch_velocity", "m/s", 1, "bridge at the first touch", &ClosingMetrics::touch_velocity},
    MetricInfo{"seat_velocity", "m/s", 1, "core at its stop", &ClosingMetrics::seat_velocity},
    MetricInfo{"first_peak", "N", 1, "largest force of a break during the first touch",
               &ClosingMetrics::first_peak},
    MetricInfo{"impulse", "mN s", 1e3, "force of a break, first touch to settled", &ClosingMetrics::impulse}};
/// nullptr for an unknown name.
const MetricInfo* find_metric(std::string_view name);

struct MetricOptions {
  double duration = 0.05;   ///< s simulated
  double tolerance = 1e-5;  ///< of the integrator
  double sample_dt = 0;     ///< s; 0: no forces, first_peak and impulse stay NaN
};

/// Those that need no samples.
ClosingMetrics closing_metrics(const ClosingTruth&);
/// Simulates the case. A specimen that is not valid throws std::invalid_argument.
ClosingMetrics closing_metrics(const Case&, const MetricOptions&);

}  // namespace powbench::sim
