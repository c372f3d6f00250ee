#pragma once

#include <algorithm>
#include <cmath>

#include "sim/mechanics/event_solver.h"

/// The fall-back for settled phases that are stiff: a Rosenbrock method of order 3 (RODAS3 of Sandu et al., stiffly
/// accurate, L-stable, four stages, three evaluations and one factorisation a step) with a Jacobian by differences.
/// It changes no modes: a step within which a guard may turn negative is refused, and the explicit solver goes on from
/// where it stands.

namespace powbench::sim {

template <class System>
class StiffSolver {
 public:
  using Real = typename System::Real;
  using GuardSet = Guards<Real, System::guard_capacity>;
  static constexpr int capacity = EventSolver<System>::capacity;
  StiffSolver(System& system, Real tolerance) : system_(&system), tolerance_(tolerance) {}

  /// Tries steps from (t, y), the first of `h` s and none beyond `largest`, until one is accepted. Then t and y are at
  /// its end and h is the next length. False: no step of `least` s or more is both accurate and free of events; t and
  /// y are where they were.
  bool step(Real& t, Real* y, Real& h, Real largest, Real least) {
    const int n = system_->size();
    system_->follow_root(-1);
    slope(t, y, f0_);
    system_->guards(t, y, f0_, begin_);
    jacobian(t, y, n);
    for (h = std::min(h, largest); h >= std::min(least, largest);) {
      const Real error = attempt(t, y, h, n);
      if constexpr (requires { system_->tried(true); }) system_->tried(error <= 1);
      const Real factor =
          std::isfinite(error)
              ? std::clamp(Real(0.9L) / std::cbrt(std::max(error, Real(1e-6L))), Real(0.2L), Real(5))
              : Real(0.1L);
      if (!(error <= 1)) {
        h *= std::min(factor, Real(0.9L));
        continue;
      }
      if (event_ahead(t + h, h)) {
        h /= 4;
        continue;
      }
      std::copy_n(next_, n, y);
      t += h;
      h *= factor;
      return true;
    }
    return false;
  }

  std::int64_t evaluations() const { return evaluations_; }

 private:
  static constexpr int stages = 4;
  static constexpr Real gamma = Real(0.5L);

  void slope(Real t, const Real* y, Real* f) {
    system_->derivative(t, y, f);
    ++evaluations_;
  }

  void jacobian(Real t, const Real* y, int n) {
    std::copy_n(y, capacity, work_);
    for (int c = 0; c < n; ++c) {
      const Real small = Real(1e-7L) * system_->scale(c);
      work_[c] = y[c] + small;
      slope(t, work_, moved_);
      for (int r = 0; r < n; ++r) jacobian_[r][c] = (moved_[r] - f0_[r]) / small;
      work_[c] = y[c];
    }
    const Real later = Real(1e-8L);
    slope(t + later, y, moved_);
    for (int r = 0; r < n; ++r) in_time_[r] = (moved_[r] - f0_[r]) / later;
  }

  /// Factors 1 / (h gamma) - J with row pivots.
  bool factor(Real h, int n) {
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < n; ++c) lu_[r][c] = (r == c ? 1 / (h * gamma) : Real(0)) - jacobian_[r][c];
    for (int c = 0; c < n; ++c) {
      int p = c;
      for (int r = c + 1; r < n; ++r)
        if (std::fabs(lu_[r][c]) > std::fabs(lu_[p][c])) p = r;
      pivot_[c] = p;
      if (!(std::fabs(lu_[p][c]) > 0)) return false;
      if (p != c) std::swap_ranges(lu_[c], lu_[c] + n, lu_[p]);
      for (int r = c + 1; r < n; ++r) {
        const Real m = lu_[r][c] /= lu_[c][c];
        if (m == 0) continue;
        for (int k = c + 1; k < n; ++k) lu_[r][k] -= m * lu_[c][k];
      }
    }
    return true;
  }
  void solve(Real* b, int n) const {
    for (int c = 0; c < n; ++c) std::swap(b[c], b[pivot_[c]]);
    for (int c = 0; c < n; ++c)
      for (int r = c + 1; r < n; ++r) b[r] -= lu_[r][c] * b[c];
    for (int r = n - 1; r >= 0; --r) {
      for (int c = r + 1; c < n; ++c) b[r] -= lu_[r][c] * b[c];
      b[r] /= lu_[r][r];
    }
  }

  /// One step into next_; returns its error in units of the tolerance.
  Real attempt(Real t, const Real* y, Real h, int n) {
    constexpr Real a[stages][stages] = {{}, {}, {2}, {2, 0, 1}};
    constexpr Real c[stages][stages] = {{}, {4}, {1, -1}, {1, -1, Real(-8.0L / 3)}};
    constexpr Real in_time[stages] = {Real(0.5L), Real(1.5L), 0, 0};
    constexpr Real weight[stages] = {2, 0, 1, 1};
    if (!factor(h, n)) return Real(INFINITY);
    for (int s = 0; s < stages; ++s) {
      if (s < 2) std::copy_n(f0_, n, f_);
      if (s >= 2) {
        std::copy_n(y, n, work_);
        for (int j = 0; j < s; ++j)
          for (int i = 0; i < n; ++i) work_[i] += a[s][j] * k_[j][i];
        slope(t + h, work_, f_);
      }
      for (int i = 0; i < n; ++i) {
        k_[s][i] = f_[i] + h * in_time[s] * in_time_[i];
        for (int j = 0; j < s; ++j) k_[s][i] += c[s][j] / h * k_[j][i];
      }
      solve(k_[s], n);
    }
    Real sum = 0;
    for (int i = 0; i < n; ++i) {
      next_[i] = y[i];
      for (int s = 0; s < stages; ++s) next_[i] += weight[s] * k_[s][i];
      const Real e = k_[stages - 1][i] / (tolerance_ * system_->scale(i));
      sum += e * e;
    }
    return std::sqrt(sum / static_cast<Real>(n));
  }

  bool event_ahead(Real end, Real h) {
    slope(end, next_, moved_);
    system_->guards(end, next_, moved_, end_);
    const StepEnds<Real> ends{h, 0, h, 0};
    for (int k = system_->smooth_guards(); k < system_->guard_count(); ++k)
      if (end_.value[k] < 0 || system_->dip(k, begin_, end_, ends) <= 1) return true;
    return may_cross(dop853::padded(system_->smooth_guards()), ends, begin_, end_);
  }

  System* system_;
  Real tolerance_;
  alignas(dop853::alignment) Real f0_[capacity] = {};
  alignas(dop853::alignment) Real f_[capacity] = {};
  alignas(dop853::alignment) Real moved_[capacity] = {};
  alignas(dop853::alignment) Real work_[capacity] = {};
  alignas(dop853::alignment) Real next_[capacity] = {};
  Real in_time_[capacity] = {};
  Real k_[stages][capacity] = {};
  Real jacobian_[capacity][capacity] = {};
  Real lu_[capacity][capacity] = {};
  int pivot_[capacity] = {};
  GuardSet begin_{};
  GuardSet end_{};
  std::int64_t evaluations_ = 0;
};

}  // namespace powbench::sim
