#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace powbench::sim {

/// sin(x) for |x| <= 1e6, to 2.4e-16: the same operations, and so the same bits, for one number (Real = double,
/// Bits = std::int64_t) and for a vector of them. x is reduced by the nearest multiple of pi, whose parts are those of
/// fdlibm (Sun Microsystems, 1993); the rest is Taylor's series to x^21.
template <class Real, class Bits>
inline __attribute__((always_inline)) Real bounded_sine(Real x) {
  constexpr double magic =
      6755399441055744.0;  // 1.5 * 2^52: what is added to it is rounded to a whole number
  const Real shifted = x * 0.31830988618379067154 + magic;
  const Real n = shifted - magic;
  const Real r = ((x - n * (2 * 1.57079632673412561417e+00)) - n * (2 * 6.07710050630396597660e-11)) -
                 n * (2 * 2.02226624879595063154e-21);
  const Real square = r * r;
  Real p = square * (1.0 / 51090942171709440000.0) - 1.0 / 121645100408832000.0;
  p = p * square + 1.0 / 355687428096000.0;
  p = p * square - 1.0 / 1307674368000.0;
  p = p * square + 1.0 / 6227020800.0;
  p = p * square - 1.0 / 39916800.0;
  p = p * square + 1.0 / 362880.0;
  p = p * square - 1.0 / 5040.0;
  p = p * square + 1.0 / 120.0;
  p = p * square - 1.0 / 6.0;
  const Real s = r + r * square * p;
  return std::bit_cast<Real>(std::bit_cast<Bits>(s) ^ (std::bit_cast<Bits>(shifted) << 63));
}

inline constexpr double sine_bound = 1e6;  ///< rad

inline double sine(double x) {
  return std::fabs(x) <= sine_bound ? bounded_sine<double, std::uint64_t>(x) : std::sin(x);
}
template <class Real>
Real sine(Real x) {
  return std::sin(x);
}

}  // namespace powbench::sim
