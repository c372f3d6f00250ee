#pragma once

#include <array>

#include "sim/vec.h"

/// The trilinear hexahedron in its own modes. With the eight corner signs
///
///   L1 = xi, L2 = eta, L3 = zeta, L4 = eta zeta, L5 = zeta xi, L6 = xi eta, L7 = xi eta zeta
///
/// (L0 = 1) any nodal field a is the sum of W_m L_m / 8, W_m = L_m . a. With X_m = W_m / 8 of the coordinates the exact
/// volume is
///
///   V = 8 ([X1 X2 X3] + ([X1 X6 X5] + [X6 X2 X4] + [X5 X4 X3]) / 3),
///
/// and its derivative by the nodal coordinates, the mean gradient operator of Flanagan and Belytschko (1981), is
/// B_a = sum over m = 1 .. 6 of L_m,a beta_m with beta_m = (dV/dX_m) / 8. The patch test passes on any shape of cell
/// because V of a mesh does not depend on its inner nodes.

namespace powbench::sim {

/// The four modes that the mean gradient of a brick does not see, numbered from 0: L4 .. L7.
inline constexpr int hourglass_modes = 4;

struct HexShape {
  double volume = 0;           ///< m3
  std::array<Vec3, 6> beta{};  ///< m2, of L1 .. L6: mean gradient of a field a = sum W_m beta_m / V
  std::array<Vec3, 4>
      hourglass{};  ///< m, L4 .. L7 . coordinates: makes gamma_h = L_h - sum_j hourglass_hj B_j / V
                    ///< orthogonal to every linear field
};

/// W_1 .. W_7 of a nodal field; [0] is W_1.
std::array<Vec3, 7> hex_modes(const std::array<Vec3, 8>& nodal);

HexShape hex_shape(const std::array<Vec3, 8>& corners);

/// B_a = dV/dx_a, m2.
std::array<Vec3, 8> hex_gradient(const HexShape&);

/// Sign of corner a in mode L1 .. L7 ([0] is L1).
double hex_sign(int mode, int corner);

}  // namespace powbench::sim
