#pragma once

#include <utility>
#include <vector>

#include "sim/magnetics/plane/field_space.h"
#include "sim/magnetics/steel.h"

/// The magnetic energy of a mesh as a convex function of the unknowns a, its gradient and Hessian:
///
///   E(a) = sum of w(|B|) over the steel + a^T K a / 2 over what is linear,   psi_k = c_k^T a for winding k.
///
/// A field with prescribed fluxes minimises E under c_k^T a = psi_k; the multipliers are the currents. One strip of air
/// may be stretched: its part of K is (g/h) K_y + (h/g) K_x with the height h as meshed and the true height g, so that
/// the derivatives by g at fixed a are exact: the pull by virtual work. Steel may go through the strip (a closed
/// leg): its B_x is h/g times, its volume g/h times the meshed one, so dE/dg = int (w - H_x B_x) dV / g there. J, Wb,
/// A, m.

namespace powbench::sim {

/// A current path: each part carries `turns` (the sign is the direction) uniformly over the section of a region.
struct Winding {
  std::vector<std::pair<int, double>> parts;  ///< region, turns
};

struct FieldSetup {
  int order = 2;
  bool axisymmetric = false;
  double depth = 1;  ///< m, planar: length of the model, copies counted
  std::vector<Steel> steels;
  std::vector<int> steel_of_region;  ///< index, -1: mu0. Regions behind the end are mu0
  std::vector<Winding> windings;
  std::vector<double> conductivity;  ///< S/m by region; regions behind the end do not conduct
  int strip_region = -1;             ///< -1: nothing moves
  int strip_steel_region = -1;       ///< -1: no steel goes through the strip
  double strip_height = 1e-3;        ///< as meshed
};

class FieldProblem {
 public:
  FieldProblem(Mesh mesh, FieldSetup setup);

  /// Puts other steels in place of those of the setup, as many.
  void set_steels(std::vector<Steel> steels);

  int size() const { return space_.size(); }
  const FieldSpace& space() const { return space_; }
  const FieldSetup& setup() const { return setup_; }

  /// c_k, and the section of the winding's parts is that of the mesh. Wb per Wb/m.
  const std::vector<double>& winding(std::size_t k) const { return windings_[k]; }

  /// Moves the vertices, m, one x and one y each; unknowns, their numbers and the pattern stay, so that a solution is a
  /// start for the moved mesh and the analysis of a factorisation goes on serving. Throws std::invalid_argument where a
  /// triangle loses its area or turns over.
  void move_vertices(std::vector<double> x, std::vector<double> y);

  /// Height of the strip, > 0. Rebuilds K.
  void set_gap(double height);
  double gap() const { return gap_; }

  const std::vector<double>& linear() const { return linear_; }  ///< values of K
  int linear_version() const { return linear_version_; }         ///< another number for other values

  /// Unknowns of the steel, 1, and all others, 0: only their entries of the Hessian change with a.
  std::vector<char> steel_unknowns() const;
  const std::vector<double>& mass() const {
    return mass_;
  }  ///< values of int sigma N_i N_j, S m; empty without conductors

  /// Steel alone: returns its energy; adds the gradient, and the Hessian where `values` is given.
  double add_steel(const double* a, double* gradient, double* values) const;

  /// The quadrature of the steel: `points` a triangle, each with its weight and with the B of every node's shape
  /// function, `lanes` x B_x, then `lanes` x B_y, as FieldSpace::lanes has them.
  struct SteelElement {
    std::size_t triangle;
    int steel;
  };
  struct SteelQuadrature {
    const std::vector<SteelElement>& elements;
    int points;
    const std::vector<double>& curls;
    const std::vector<double>& weights;
  };
  SteelQuadrature steel_quadrature() const { return {elements_, points_, curls_, weights_}; }

  /// Energy of the steel at a + s d for many s: the flux densities are kept.
  class Ray {
   public:
    Ray(const FieldProblem&, const double* a, const double* d);
    double steel_energy(double s) const;

   private:
    const FieldProblem& problem_;
    std::vector<double> b_;  ///< B and dB/ds, four a point
  };

  /// dE/dg, d2E/dg2, and y = d2E/dg da. At fixed a.
  double gap_slope(const double* a) const;
  double gap_curvature(const double* a) const;
  void gap_gradient(const double* a, double* y) const;

  /// Largest flux density in the steel, T.
  double largest_field(const double* a) const;

  /// Share of the steel's volume that is above the last row of its curve (Steel::data_end); 0 without steel.
  double share_beyond_data(const double* a) const;

  /// B at barycentric coordinates of a triangle; the true height of the strip counted.
  std::pair<double, double> field(std::size_t triangle, const std::array<double, 3>& l,
                                  const double* a) const;

  /// Force on the body moved with `weight` (by vertex; 1 on the body, 0 on what stands still, between them in air):
  /// int T . grad(weight), in y. Only triangles over which the weight varies count: air, or steel that stretches,
  /// where T is the tensor of virtual work with H = dw/dB.
  double stress_force(const double* a, const std::vector<double>& weight) const;

 private:
  void sort_elements();
  double centre_square(std::size_t element, const double* a) const;
  void build_steel();
  void build_linear();
  void build_windings();
  void stretch_steel();
  void sum_strip_rows();
  void add_strip(const double* a, double by_x, double by_y, double* y) const;
  double strip_energy(const double* a, double by_x, double by_y) const;
  template <class Visit>
  void each_stretched(const double* a, const Visit& visit) const;
  template <int nodes, int lanes>
  double add_steel_by(const double* a, double* gradient, double* values) const;

  FieldSetup setup_;
  FieldSpace space_;
  std::vector<SteelElement> elements_;
  int points_ = 3;               ///< of the quadrature in the steel
  std::vector<double> curls_;    ///< by element and point: lanes x curl_x, lanes x curl_y
  std::vector<double> weights_;  ///< by element and point
  std::vector<double> meshed_curls_, meshed_weights_;  ///< of all steel, where some goes through the strip
  std::vector<double> centre_curls_;                   ///< by element and node: curl_x, curl_y in the middle
  std::vector<double> fixed_, linear_, mass_;
  /// One entry of K_x and K_y of the strip: where it is, and at which place of the values.
  struct StripEntry {
    int row, column, at;
    double x, y;
  };
  std::vector<StripEntry> strip_;
  std::vector<StripEntry> strip_rest_;  ///< on the diagonal: what a row sums up to beside a given potential
  std::vector<std::vector<double>> windings_;
  double gap_ = 0;
  int linear_version_ = 0;
};

}  // namespace powbench::sim
