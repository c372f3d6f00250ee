#pragma once

#include <vector>

#include "sim/magnetics/space/coenergy.h"

/// Fields of a solution at points.

namespace powbench::bench {

class Probe {
 public:
  /// Keeps references to the function and to its problem.
  Probe(const sim::space::Coenergy&, const sim::space::State&);

  struct Sample {
    int cell = -1;  ///< -1: the point lies outside the mesh
    sim::Vec3 h{};  ///< A/m
    sim::Vec3 b{};  ///< T
  };
  /// On a face between cells: the field in the cell of lower number.
  Sample at(const sim::Vec3& point) const;

 private:
  bool locate(int cell, const sim::Vec3& point, sim::Vec3& xi) const;

  const sim::space::Coenergy& function_;
  const sim::space::State& state_;
  std::vector<double> potential_;
  std::vector<sim::space::MediumLaw> laws_;
  std::vector<sim::Vec3> low_, high_;  ///< [cell] bounds
};

}  // namespace powbench::bench
