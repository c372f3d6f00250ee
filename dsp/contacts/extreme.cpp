#include "dsp/contacts/extreme.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dsp/signal/least_squares.h"

namespace powbench::dsp {

namespace {

constexpr std::size_t order = 5;  // coefficients of the polynomial through an extreme

struct Polynomial {
  bool known = false;
  double reduced_chi2 = 0;
  Measured most;  ///< largest value on the samples, times `side`
};

/// Fitted to samples a .. b - 1, with time in units of `half` from sample `at`.
Polynomial polynomial_through(const Signal& s, std::size_t a, std::size_t b, std::size_t at, double half,
                              int side, double noise) {
  Polynomial out;
  std::vector<std::vector<double>> columns(order);
  std::vector<double> y;
  const auto x_of = [&](std::size_t i) { return (s.time(i) - s.time(at)) / half; };
  for (std::size_t i = a; i < b; ++i) {
    if (s.masked[i]) continue;
    double p = 1;
    for (auto& c : columns) c.push_back(p / noise), p *= x_of(i);
    y.push_back(side * s.value[i] / noise);
  }
  if (y.size() < order + 1) return out;
  const LeastSquares fit = linear_least_squares(columns, y);
  out.known = true;
  out.reduced_chi2 = fit.chi2 / static_cast<double>(y.size() - order);
  out.most = {-1e300, 0};
  for (std::size_t i = a; i < b; ++i) {
    double p = 1, v = 0, variance = 0;
    std::array<double, order> powers{};
    for (std::size_t k = 0; k < order; ++k, p *= x_of(i)) powers[k] = p, v += p * fit.x[k];
    if (v <= out.most.value) continue;
    for (std::size_t j = 0; j < order; ++j)
      for (std::size_t k = 0; k < order; ++k)
        variance += powers[j] * powers[k] * fit.covariance[j * order + k];
    out.most = {v, std::sqrt(std::max(variance, 0.0))};
  }
  return out;
}

bool follows(const Polynomial& p, std::size_t samples) {
  const double dof = std::max(1.0, static_cast<double>(samples) - static_cast<double>(order));
  return p.reduced_chi2 < 1 + 2 * std::sqrt(2 / dof);
}

}  // namespace

Measured locate_extreme(const Signal& s, double from, double to, int side, double noise) {
  const std::size_t i1 = s.index_at(from), i2 = std::min(s.index_at(to), s.size());
  if (i2 < i1 + order + 1) return {};
  const std::size_t smooth = std::max<std::size_t>(1, (i2 - i1) / 24);
  double top = -1e300, sum = 0;
  std::size_t at = i1;
  for (std::size_t i = i1; i < i2; ++i) {
    sum += side * (s.value[i] - (i >= i1 + smooth ? s.value[i - smooth] : 0.0));
    if (i + 1 < i1 + smooth) continue;
    if (sum > top) top = sum, at = i - smooth / 2;
  }
  Measured before;
  bool followed = false;
  for (double half = 0.3 * (to - from);; half *= 0.7) {
    const auto reach = static_cast<std::size_t>(half / s.dt);
    const std::size_t a = at > i1 + reach ? at - reach : i1, b = std::min(at + reach + 1, i2);
    if (b < a + order + 1) return before;
    const Polynomial p = polynomial_through(s, a, b, at, half, side, noise);
    if (!p.known) return before;
    Measured now{side * p.most.value, p.most.u};
    // what the next narrower one says differently was not followed, only hidden by the noise
    const double apart = before.known() ? now.value - before.value : 0.0;
    if (followed) return {before.value, std::hypot(before.u, 0.7 * apart)};
    followed = follows(p, b - a);
    if (!followed) now.u = std::hypot(now.u * std::sqrt(p.reduced_chi2), 0.5 * apart);
    before = now;
  }
}

}  // namespace powbench::dsp
