#pragma once

/// Elliptic integrals and Jacobi functions by arithmetic-geometric means (Abramowitz and Stegun 16.4, 17.6).
/// A modulus k always comes with its complement kc = sqrt(1 - k^2), so that neither loses digits near 0 or 1.

namespace powbench::dsp {

struct Modulus {
  double k = 0, kc = 1;
};

struct Jacobi {
  double sn = 0, cn = 1, dn = 1;
};

/// Complete integral of the first kind K(k), from the complement alone. kc in (0, 1].
double complete_integral(double kc);

/// F(atan(tangent), k) from the complement kc. tangent >= 0, kc in (0, 1].
double incomplete_integral(double tangent, double kc);

/// sn, cn, dn of u by descending Landen steps.
Jacobi jacobi(double u, Modulus);

/// Modulus whose K'/K is `ratio`, through the nome q = exp(-pi ratio). ratio > 0.03.
Modulus modulus_from_ratio(double ratio);

}  // namespace powbench::dsp
