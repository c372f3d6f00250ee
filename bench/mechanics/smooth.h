#pragma once

#include <functional>

#include "bench/mechanics/no_roots.h"
#include "sim/mechanics/event_solver.h"

namespace powbench::sim {

/// An ordinary differential equation without events, or with one guard that `at_zero` answers.
template <int States>
struct Smooth : NoRoots<double> {
  static constexpr int capacity = States;
  static constexpr int guard_capacity = 8;
  using GuardSet = Guards<double, guard_capacity>;
  std::function<void(double, const double*, double*)> rate;
  std::function<double(double, const double*)> positive;  ///< valid while > 0
  std::function<void(double&, double*)> at_zero;
  double tolerance_scale = 1;

  int size() const { return States; }
  int guard_count() const { return positive ? 1 : 0; }
  int smooth_guards() const { return 0; }
  double scale(int) const { return tolerance_scale; }
  void derivative(double t, const double* y, double* dy) const { rate(t, y, dy); }
  void guards(double t, const double* y, const double*, GuardSet& g) const {
    if (positive) g.value[0] = positive(t, y);
  }
  double guard(int, double t, const double* y, double&) const { return positive(t, y); }
  void flip(double& t, double* y, std::uint64_t) { at_zero(t, y); }
};

}  // namespace powbench::sim
