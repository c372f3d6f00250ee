#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "sim/magnetics/space/medium.h"
#include "sim/magnetics/space/mesh.h"

/// A magnetostatic problem in three dimensions, in the form H = sum_k I_k T_k - grad u.
///
/// T_k is any field with curl T_k = the current density of winding k for 1 A; u is the scalar potential, A. Then
/// curl H = J holds exactly and div B(H) = 0 is the condition for the least co-energy
///
///   W'(u, I) = int w'(H) dV,   w'(H) = int_0^H B dH,   psi_k = dW'/dI_k = int B . T_k dV.
///
/// Iron wants T_k to be the gradient of something the shape functions hold exactly there: constant in boxes whose faces
/// are planes of the mesh. No gauge, no divergence-free source, a positive definite matrix.

namespace powbench::sim::space {

struct Problem {
  Mesh mesh;
  std::vector<Medium> media;                               ///< by region
  std::vector<std::function<Vec3(const Vec3&)>> windings;  ///< T_k, A/m per ampere
  std::vector<double>
      series;             ///< H in series with each winding: leakage that the mesh does not hold; empty: none
  std::vector<int> tied;  ///< [node] the node with the same potential; empty: each its own
  std::vector<std::pair<int, double>> fixed;  ///< nodes with a given potential, A. None: one node is held
  double copies = 1;  ///< of this part in the whole: 2 for a half model, 4 for a quarter
};

/// Where the potential has no given value, its natural condition is B . n = 0; a constant value is H x n = 0.

/// A solution, or a point on the way to it.
struct State {
  std::vector<double> u;        ///< unknown potentials, A
  std::vector<double> current;  ///< of each winding, A
};

}  // namespace powbench::sim::space
