#include "host/compare/student.h"

#include <cmath>
#include <stdexcept>

#include "core/units.h"

namespace powbench::host {
namespace {

/// log Gamma(x) for x > 0, by the Stirling series after shifting x above 10: unlike std::lgamma it has no global state.
double log_gamma(double x) {
  double shift = 0;
  for (; x < 10; ++x) shift += std::log(x);
  const double r = 1 / (x * x);
  const double series = (1.0 / 12 - r * (1.0 / 360 - r * (1.0 / 1260 - r * (1.0 / 1680 - r / 1188)))) / x;
  return (x - 0.5) * std::log(x) - x + 0.5 * std::log(2 * pi) + series - shift;
}

/// Continued fraction of the incomplete beta function, by the modified Lentz method. Converges for x < (a+1)/(a+b+2).
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto guarded = [](double v) { return std::fabs(v) < tiny ? tiny : v; };
  double c = 1, d = 1 / guarded(1 - (a + b) * x / (a + 1)), h = d;
  for (int m = 1; m <= 500; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / guarded(1 + even * d);
    c = guarded(1 + even / c);
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / guarded(1 + odd * d);
    c = guarded(1 + odd / c);
    h *= d * c;
    if (std::fabs(d * c - 1) < 1e-15) break;
  }
  return h;
}

/// Regularised incomplete beta function I_x(a, b); `y` = 1 - x, passed on its own to keep its digits.
double incomplete_beta(double a, double b, double x, double y) {
  if (x <= 0) return 0;
  if (y <= 0) return 1;
  const double front =
      std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * std::log(x) + b * std::log(y));
  return x < (a + 1) / (a + b + 2) ? front * beta_fraction(a, b, x) / a
                                   : 1 - front * beta_fraction(b, a, y) / b;
}

}  // namespace

double student_probability(double t, double dof) {
  if (!(dof < 1e7)) return std::erf(t / std::sqrt(2.0));  // the difference is below 1e-7
  const double sum = dof + t * t;
  return 1 - incomplete_beta(0.5 * dof, 0.5, dof / sum, t * t / sum);
}

double coverage_factor(double dof, double probability) {
  if (!(dof > 0)) throw std::invalid_argument("dof: allowed > 0");
  if (!(probability > 0 && probability < 1)) throw std::invalid_argument("probability: allowed 0 < p < 1");
  double low = 0, high = 1;
  while (student_probability(high, dof) < probability && high < 1e12) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-13 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (student_probability(middle, dof) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace powbench::host
