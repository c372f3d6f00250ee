#include "dsp/filter/prototype.h"

#include <cmath>

#include "core/units.h"
#include "dsp/filter/elliptic.h"

namespace powbench::dsp {

namespace {

using Complex = std::complex<double>;

/// Butterworth circle point k: exp(i pi (2k + N + 1) / 2N), exactly real in the middle.
Complex circle(int k, int order) {
  const double angle = pi * (2.0 * k + order + 1) / (2.0 * order);
  return {std::cos(angle), 2 * k + 1 == order ? 0.0 : std::sin(angle)};
}

Prototype butterworth(int order) {
  Prototype p;
  for (int k = 0; k < order; ++k) p.poles.push_back(circle(k, order));
  return p;
}

/// Poles on an ellipse with half axes sinh(mu), cosh(mu).
std::vector<Complex> ellipse(int order, double mu) {
  std::vector<Complex> poles;
  for (int k = 0; k < order; ++k) {
    const Complex c = circle(k, order);
    poles.emplace_back(c.real() * std::sinh(mu), c.imag() * std::cosh(mu));
  }
  return poles;
}

Prototype chebyshev1(int order, double ripple_db) {
  const double eps = std::sqrt(excess_power(ripple_db));
  Prototype p;
  p.poles = ellipse(order, std::asinh(1 / eps) / order);
  if (order % 2 == 0) p.dc_gain = 1 / std::sqrt(1 + eps * eps);
  return p;
}

Prototype chebyshev2(int order, double stop_db) {
  const double inverse_eps = std::sqrt(excess_power(stop_db));
  Prototype p;
  for (const Complex s : ellipse(order, std::asinh(inverse_eps) / order)) p.poles.push_back(1.0 / s);
  for (int j = order - 1; j > 0; j -= 2) p.zeros.push_back(1 / std::sin(pi * j / (2.0 * order)));
  return p;
}

/// Poles of the elliptic filter: cd and sn at u + i v0 with u = j K / N (Orfanidis, lecture notes on elliptic
/// filter design, 2006).
Prototype elliptic(int order, double ripple_db, double stop_db) {
  const double eps = std::sqrt(excess_power(ripple_db));
  const double k1 = eps / std::sqrt(excess_power(stop_db)), k1c = std::sqrt((1 - k1) * (1 + k1));
  const double K1 = complete_integral(k1c), K1c = complete_integral(k1);
  const Modulus m = modulus_from_ratio(K1c / (K1 * order));
  const double K = complete_integral(m.kc);
  const double v0 = K * incomplete_integral(1 / eps, k1) / (order * K1);
  const Jacobi v = jacobi(v0, {m.kc, m.k});
  Prototype p;
  for (int j = 1 - order % 2; j < order; j += 2) {
    const Jacobi u = jacobi(j * K / order, m);
    const double denominator = v.cn * v.cn + m.k * m.k * u.sn * u.sn * v.sn * v.sn;
    const Complex pole(-u.cn * u.dn * v.sn * v.cn / denominator, -u.sn * v.dn / denominator);
    if (j == 0) {
      p.poles.emplace_back(pole.real(), 0.0);
      continue;
    }
    p.poles.push_back(pole);
    p.poles.push_back(std::conj(pole));
    p.zeros.push_back(1 / (m.k * u.sn));
  }
  if (order % 2 == 0) p.dc_gain = 1 / std::sqrt(1 + eps * eps);
  return p;
}

}  // namespace

double excess_power(double db) {
  return std::expm1(db * std::log(10.0) / 10);
}

Prototype prototype(FilterFamily family, int order, double ripple_db, double stop_db) {
  Prototype p;
  switch (family) {
    case FilterFamily::butterworth:
      p = butterworth(order);
      break;
    case FilterFamily::chebyshev1:
      p = chebyshev1(order, ripple_db);
      break;
    case FilterFamily::chebyshev2:
      p = chebyshev2(order, stop_db);
      break;
    case FilterFamily::elliptic:
      p = elliptic(order, ripple_db, stop_db);
      break;
  }
  Complex h = p.dc_gain;
  for (const Complex s : p.poles) h *= -s;
  for (const double w : p.zeros) h /= w * w;
  p.gain = h.real();
  return p;
}

}  // namespace powbench::dsp
