#pragma once

#include <vector>

#include "sim/field3d/coenergy3.h"

/// Fields of a solution at points.

namespace powbench::sim {

class Probe3 {
 public:
  /// Keeps references to the function and to its problem.
  Probe3(const Coenergy3&, const State3&);

  struct Sample {
    int cell = -1;  ///< -1: the point lies outside the mesh
    Vec3 h{};       ///< A/m
    Vec3 b{};       ///< T
  };
  /// On a face between cells: the field in the cell of lower number.
  Sample at(const Vec3& point) const;

 private:
  bool locate(int cell, const Vec3& point, Vec3& xi) const;

  const Coenergy3& function_;
  const State3& state_;
  std::vector<double> potential_;
  std::vector<MediumLaw> laws_;
  std::vector<Vec3> low_, high_;  ///< [cell] bounds
};

}  // namespace powbench::sim
