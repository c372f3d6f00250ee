#include "sim/solid/hex_shape.h"

namespace powbench::sim {

double hex_sign(int mode, int corner) {
  static constexpr int axes[3][8] = {
      {-1, 1, 1, -1, -1, 1, 1, -1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, -1, -1, -1, 1, 1, 1, 1}};
  const int xi = axes[0][corner], eta = axes[1][corner], zeta = axes[2][corner];
  switch (mode) {
    case 0:
      return xi;
    case 1:
      return eta;
    case 2:
      return zeta;
    case 3:
      return eta * zeta;
    case 4:
      return zeta * xi;
    case 5:
      return xi * eta;
    default:
      return xi * eta * zeta;
  }
}

std::array<Vec3, 7> hex_modes(const std::array<Vec3, 8>& nodal) {
  std::array<Vec3, 7> w{};
  for (int m = 0; m < 7; ++m)
    for (int a = 0; a < 8; ++a)
      w[static_cast<std::size_t>(m)] += hex_sign(m, a) * nodal[static_cast<std::size_t>(a)];
  return w;
}

HexShape hex_shape(const std::array<Vec3, 8>& corners) {
  const auto w = hex_modes(corners);
  std::array<Vec3, 7> x;
  for (std::size_t m = 0; m < 7; ++m) x[m] = 0.125 * w[m];
  const Vec3 &x1 = x[0], &x2 = x[1], &x3 = x[2], &x4 = x[3], &x5 = x[4], &x6 = x[5];
  constexpr double third = 1.0 / 3;
  HexShape s;
  s.beta[0] = cross(x2, x3) + third * cross(x6, x5);
  s.beta[1] = cross(x3, x1) + third * cross(x4, x6);
  s.beta[2] = cross(x1, x2) + third * cross(x5, x4);
  s.beta[3] = third * (cross(x3, x5) + cross(x6, x2));
  s.beta[4] = third * (cross(x4, x3) + cross(x1, x6));
  s.beta[5] = third * (cross(x2, x4) + cross(x5, x1));

  s.volume = 8 * (dot(x1, cross(x2, x3)) +
                  third * (dot(x1, cross(x6, x5)) + dot(x6, cross(x2, x4)) + dot(x5, cross(x4, x3))));
  for (std::size_t h = 0; h < 4; ++h) s.hourglass[h] = w[3 + h];
  return s;
}

std::array<Vec3, 8> hex_gradient(const HexShape& s) {
  std::array<Vec3, 8> b{};
  for (int a = 0; a < 8; ++a)
    for (int m = 0; m < 6; ++m)
      b[static_cast<std::size_t>(a)] += hex_sign(m, a) * s.beta[static_cast<std::size_t>(m)];
  return b;
}

}  // namespace powbench::sim
