#include "host/report/best_angle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "host/compare/student.h"

namespace powbench::host {
namespace {

double probability_below(const ComparisonRow& other, const ComparisonRow& best) {
  const double u = std::hypot(other.measured.u, best.measured.u);
  const double difference = other.measured.value - best.measured.value;
  if (!(u > 0)) return difference > 0 ? 0.0 : 0.5;
  return 0.5 * (1 - student_probability(difference / u, std::min(other.dof, best.dof)));
}

}  // namespace

BestAngle best_angle(const Comparison& comparison) {
  std::vector<const ComparisonRow*> rows, unsettled;
  for (const auto& row : comparison.rows)
    if (row.quantity == "t_ct_bon" && row.measured.known() && std::isfinite(row.closing_angle))
      (row.repeats < row.closings ? unsettled : rows).push_back(&row);
  BestAngle b;
  b.unsettled = static_cast<int>(unsettled.size());
  b.angles = static_cast<int>(rows.size());
  if (rows.empty()) return b;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto* x, const auto* y) { return x->measured.value < y->measured.value; });
  const ComparisonRow& best = *rows.front();
  b.angle = best.closing_angle;
  b.bounce = best.measured;
  b.coverage = best.coverage;
  b.two_modes = best.two_modes;
  if (rows.size() < 2) return b;
  b.runner_up = rows[1]->closing_angle;
  const double n = static_cast<double>(rows.size());
  double mean = 0, variance = 0, below = 0, by_dof = 0;
  bool scatter_known = true;
  for (const auto* row : rows) {
    mean += row->measured.value / n;
    const double weight = 1 / n - (row == rows.front() ? 1 : 0);
    const double part = weight * weight * row->measured.u * row->measured.u;
    variance += part;
    by_dof += part * part / row->dof;
    scatter_known = scatter_known && row->repeats >= 2 && std::isfinite(row->measured.u);
    if (row != rows.front()) below += probability_below(*row, best);
  }
  b.gain = {mean - best.measured.value, std::sqrt(variance)};
  b.gain_coverage =
      coverage_factor(by_dof > 0 ? variance * variance / by_dof : std::numeric_limits<double>::infinity());
  if (scatter_known) b.confidence = std::max(0.0, 1 - below);
  return b;
}

}  // namespace powbench::host
