#include "dsp/filter/elliptic.h"

#include <array>
#include <cmath>

#include "core/units.h"

namespace powbench::dsp {

namespace {

constexpr int max_steps = 12;  // convergence is quadratic; 7 steps already serve kc = 1e-12

}  // namespace

double complete_integral(double kc) {
  double a = 1, b = kc;
  for (int i = 0; i < max_steps && std::abs(a - b) > 1e-16 * a; ++i) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return pi / (a + b);
}

double incomplete_integral(double tangent, double kc) {
  double a = 1, b = kc, phi = std::atan(tangent), t = tangent, scale = 1;
  for (int i = 0; i < max_steps && std::abs(a - b) > 1e-16 * a; ++i) {
    // tan(phi' - phi) = (b / a) tan(phi), on the branch of phi
    phi += std::atan(b / a * t) + pi * std::round(phi / pi);
    t = std::tan(phi);
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
    scale *= 2;
  }
  return phi / (scale * a);
}

Jacobi jacobi(double u, Modulus m) {
  std::array<double, max_steps + 1> a{1.0}, c{m.k};
  double b = m.kc, scale = 1;
  int n = 0;
  while (n < max_steps && std::abs(c[n]) > 1e-17 * a[n]) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    scale *= 2;
    ++n;
  }
  double phi = scale * a[n] * u;
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  const double sn = std::sin(phi), cn = std::cos(phi);
  return {sn, cn, std::sqrt(m.kc * m.kc + m.k * m.k * cn * cn)};
}

Modulus modulus_from_ratio(double ratio) {
  const double q = std::exp(-pi * ratio);
  double theta2 = 0, theta3 = 1, theta4 = 1;
  for (int m = 0; m < 64; ++m) {
    theta2 += std::pow(q, m * (m + 1.0));
    if (m == 0) continue;
    const double term = 2 * std::pow(q, static_cast<double>(m) * m);
    theta3 += term;
    theta4 += m % 2 ? -term : term;
  }
  const double k = theta2 / theta3, kc = theta4 / theta3;
  return {4 * std::sqrt(q) * k * k, kc * kc};
}

}  // namespace powbench::dsp
