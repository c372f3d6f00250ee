#pragma once

#include <array>
#include <memory>
#include <vector>

#include "sim/magnetics/space/mesh.h"
#include "sim/magnetics/steel.h"

/// What fills a region, as a law B(H) with its co-energy. SI.

namespace powbench::sim::space {

/// A linear medium, or a steel, or a stack of laminations: along the sheets a steel's curve, across them a constant.
struct Medium {
  double permeability = 0;             ///< H/m, of a linear medium
  std::shared_ptr<const Steel> steel;  ///< null: linear
  double across = 0;                   ///< H/m along `axis`; 0: the steel is the same in all directions
  int axis = 1;                        ///< normal of the sheets: 0 x, 1 y, 2 z
};

Medium air();
Medium solid(const Steel&);

/// Laminations with normal `axis` and this share of iron in (0, 1]. Along the sheets Steel::stacked; across them the
/// flux passes the insulation in series, mu0 / (1 - share), and at most the steel's own peak permeability.
Medium laminated(const Steel&, double share, int axis);

/// Co-energy density, flux density and its derivative at one field.
struct MediumPoint {
  double coenergy = 0;            ///< J/m3, int B dH from 0
  Vec3 b{};                       ///< T
  std::array<double, 6> slope{};  ///< dB/dH: xx, yy, zz, xy, xz, yz, H/m
};

/// D v for a symmetric D as MediumPoint::slope.
inline Vec3 times(const std::array<double, 6>& d, const Vec3& v) {
  return {d[0] * v[0] + d[3] * v[1] + d[4] * v[2], d[3] * v[0] + d[1] * v[1] + d[5] * v[2],
          d[4] * v[0] + d[5] * v[1] + d[2] * v[2]};
}

/// B(H) of one steel: the inverse of its H(B), by bisection over the knots and Newton inside, to 1e-13 of B.
class SteelInverse {
 public:
  explicit SteelInverse(const Steel&);
  /// B for h >= 0, and the steel's point there.
  double b(double h, SteelPoint& point) const;

 private:
  const Steel* steel_;
  std::vector<double> h_;  ///< of the knots
};

class MediumLaw {
 public:
  explicit MediumLaw(const Medium&);
  bool linear() const { return !inverse_; }
  MediumPoint at(const Vec3& h) const;

 private:
  Medium medium_;
  std::shared_ptr<const SteelInverse> inverse_;
};

}  // namespace powbench::sim::space
