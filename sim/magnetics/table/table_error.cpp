#include <algorithm>
#include <cmath>

#include "sim/magnetics/table/potential_table.h"

namespace powbench::sim {
namespace {

/// Cubic through values and slopes at x0 and x1, at x.
double hermite(double x0, double f0, double d0, double x1, double f1, double d1, double x) {
  const double h = x1 - x0, t = (x - x0) / h;
  const double c2 = 3 * (f1 - f0) - (2 * d0 + d1) * h, c3 = 2 * (f0 - f1) + (d0 + d1) * h;
  return f0 + t * (d0 * h + t * (c2 + t * c3));
}

struct Estimator {
  const PotentialTable& t;
  std::size_t np = t.psi.size(), nr = std::max<std::size_t>(1, t.ring.size()), ng = t.gap.size();
  std::size_t gap_derivative = t.values() / 2;

  double node(std::size_t p, std::size_t r, std::size_t g, std::size_t at) const {
    return t.nodes[(p + np * (r + nr * g)) * t.values() + at];
  }

  /// What node k of an axis misses: quantity `value` with its derivative `slope` along that axis, predicted from k - 1
  /// and k + 1; `own`: the quantity is itself the slope of `value`.
  template <class Get>
  static double missed(const std::vector<double>& x, std::size_t k, const Get& get, std::size_t value,
                       std::size_t slope, bool own) {
    if (k == 0 || k + 1 >= x.size()) return 0;
    const double miss = std::fabs(hermite(x[k - 1], get(k - 1, value), get(k - 1, slope), x[k + 1],
                                          get(k + 1, value), get(k + 1, slope), x[k]) -
                                  get(k, value));
    // error c t^2 (1 - t)^2: c / 16 in the middle of the double cell; the slope errs by 0.19 c / width of a cell
    return own ? 0.2 * miss / (0.5 * (x[k + 1] - x[k - 1])) : miss / 16;
  }

  /// Absolute errors of current and pull at a node.
  std::pair<double, double> at(std::size_t p, std::size_t r, std::size_t g) const {
    const auto along_psi = [&](std::size_t k, std::size_t a) { return node(k, r, g, a); };
    const auto along_gap = [&](std::size_t k, std::size_t a) { return node(p, r, k, a); };
    const auto along_ring = [&](std::size_t k, std::size_t a) { return node(p, k, g, a); };
    const std::size_t d = gap_derivative;
    double current = missed(t.psi, p, along_psi, 0, 1, true) + missed(t.gap, g, along_gap, 1, 1 + d, false);
    double pull = missed(t.psi, p, along_psi, d, d + 1, false) + missed(t.gap, g, along_gap, 0, d, true);
    if (!t.ring.empty()) {
      current += missed(t.ring, r, along_ring, 1, 3, false);
      pull += missed(t.ring, r, along_ring, 4, 6, false);
    }
    return {current, pull};
  }
};

}  // namespace

void estimate_errors(PotentialTable& t) {
  const Estimator e{t};
  t.current_error.clear();
  t.pull_error.clear();
  double largest_current = 0, largest_pull = 0;
  for (std::size_t k = 0; k < t.nodes.size(); k += t.values()) {
    largest_current = std::max(largest_current, std::fabs(t.nodes[k + 1]));
    largest_pull = std::max(largest_pull, std::fabs(t.nodes[k + e.gap_derivative]));
  }
  constexpr double floor = 0.002;  // of the largest value: below it a relative error means nothing
  const std::size_t cells_r = std::max<std::size_t>(1, e.nr - 1), ring_ends = t.ring.empty() ? 1 : 2;
  for (std::size_t g = 0; g + 1 < e.ng; ++g)
    for (std::size_t r = 0; r < cells_r; ++r)
      for (std::size_t p = 0; p + 1 < e.np; ++p) {
        double current = 0, pull = 0;
        for (std::size_t dg = 0; dg < 2; ++dg)
          for (std::size_t dr = 0; dr < ring_ends; ++dr)
            for (std::size_t dp = 0; dp < 2; ++dp) {
              const auto [i, f] = e.at(p + dp, r + dr, g + dg);
              const double size_i = std::fabs(e.node(p + dp, r + dr, g + dg, 1));
              const double size_f = std::fabs(e.node(p + dp, r + dr, g + dg, e.gap_derivative));
              current = std::max(current, i / std::max(size_i, floor * largest_current));
              pull = std::max(pull, f / std::max(size_f, floor * largest_pull));
            }
        t.current_error.push_back(current);
        t.pull_error.push_back(pull);
      }
}

ExtrapolatedShare extrapolated_share(const PotentialTable& t) {
  ExtrapolatedShare e;
  std::size_t beyond = 0;
  for (std::size_t n = 0; n < t.steel_field.size(); ++n) {
    e.largest_field = std::max(e.largest_field, t.steel_field[n]);
    if (!(t.data_end > 0 && t.steel_field[n] > t.data_end)) continue;
    const std::size_t line = n / t.psi.size();
    const double ring = t.ring.empty() ? 0 : t.ring[line % t.ring.size()];
    const double psi = std::fabs(t.psi[n % t.psi.size()] + t.ring_ratio * ring);
    e.from_psi = beyond == 0 ? psi : std::min(e.from_psi, psi);
    ++beyond;
  }
  if (beyond > 0) e.share = static_cast<double>(beyond) / static_cast<double>(t.steel_field.size());
  return e;
}

}  // namespace powbench::sim
