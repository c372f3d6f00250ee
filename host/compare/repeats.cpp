#include "host/compare/repeats.h"

#include <algorithm>
#include <cmath>

#include "host/compare/student.h"

namespace powbench::host {

bool splits_in_two(std::vector<double> values, double u) {
  if (values.size() < 4) return false;
  std::sort(values.begin(), values.end());
  std::size_t split = 2;
  for (std::size_t i = 2; i + 2 <= values.size(); ++i)
    if (values[i] - values[i - 1] > values[split] - values[split - 1]) split = i;
  const double empty = values[split] - values[split - 1];
  const double within = std::max(values[split - 1] - values.front(), values.back() - values[split]);
  return empty > 5 * within && empty > 5 * (std::isfinite(u) ? u : 0);
}

Repeats repeats_of(const std::vector<Measured>& values) {
  Repeats r;
  std::vector<double> known;
  double sum_b = 0;
  int with_u = 0;
  for (const auto& m : values) {
    if (!m.known()) continue;
    known.push_back(m.value);
    if (!std::isfinite(m.u)) continue;
    sum_b += m.u * m.u;
    ++with_u;
  }
  if (known.empty()) return r;
  r.n = static_cast<int>(known.size());
  double sum = 0;
  for (const double x : known) sum += x;
  r.mean = sum / r.n;
  r.lowest = *std::min_element(known.begin(), known.end());
  r.highest = *std::max_element(known.begin(), known.end());

  double u_a = 0;
  if (r.n > 1) {
    double squares = 0;
    for (const double x : known) squares += (x - r.mean) * (x - r.mean);
    r.scatter = std::sqrt(squares / (r.n - 1));
    u_a = r.scatter / std::sqrt(static_cast<double>(r.n));
  }
  const double u_b = with_u > 0 ? std::sqrt(sum_b / with_u) : 0;
  if (r.n > 1 || with_u > 0) {
    r.u = std::hypot(u_a, u_b);
    if (u_a > 0) r.dof = (r.n - 1) * std::pow(r.u / u_a, 4);
    r.coverage = coverage_factor(r.dof);
  }
  r.two_modes = splits_in_two(known, u_b);
  return r;
}

}  // namespace powbench::host
