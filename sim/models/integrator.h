#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "sim/mechanics/chatter_lock.h"
#include "sim/models/dormand_prince.h"

/// Integration of a system with modes: smooth between events, switched at the zero of a guard.

namespace powbench::sim {

/// A guard that dips between two samples may dip below zero: the parabola through them reaches an eighth of its
/// curvature below the middle one at most; where that one is above the whole curvature there is no need to look.
template <class T>
inline auto dips_low(T before, T at, T after) {
  return (at < before) & (at <= after) & (at < before - 2 * at + after);
}

/// Event-locating integrator over a `System` with
///   `static constexpr int capacity, guard_capacity`   largest number of states and of guards (<= 64)
///   `int size()`, `int guard_count()`, `double scale(int i)`   the tolerance is `tolerance * scale(i)` for
///   state i `void derivative(double t, const double* y, double* dy)` `void guards(double t, const double* y,
///   double* g)`   g[k] > 0 while mode k stays valid `void flip(double t, double* y, std::uint64_t which)`
///   switches the modes whose bits are set
///
/// A step ends at the earliest zero of a guard, found on the dense output; everything that has changed sign
/// there switches together, so the result does not depend on the order of the guards. A guard that keeps
/// switching is ignored for a while (`ChatterLock`): accumulating events cannot stop the clock.
template <class System>
class EventIntegrator {
 public:
  using State = std::array<double, System::capacity>;
  using Guards = std::array<double, System::guard_capacity>;

  static constexpr double smallest_step = 1e-12;  ///< s

  EventIntegrator(System& system, double tolerance, double largest_step)
      : system_(&system), tolerance_(tolerance), largest_step_(largest_step) {}

  /// Goes on with another system in the same state: what a copy of this integrator needs.
  void attach(System& system) { system_ = &system; }

  /// Starts anew at (t, y). The first step is tried with `step`.
  void restart(double t, const State& y, double step) {
    y_ = y;
    begin_ = end_ = t;
    next_step_ = std::min(step, largest_step_);
    pending_ = 0;
    first_slope_known_ = false;
  }

  double begin() const { return begin_; }  ///< s: the dense output covers [begin, end]
  double end() const { return end_; }
  std::int64_t evaluations() const { return evaluations_; }
  std::int64_t steps() const { return steps_; }
  double next_step() const { return next_step_; }
  const State& end_state() const { return y_; }

  /// State at `t` in [begin, end].
  void state(double t, State& out) const {
    if (t >= end_) {
      out = y_;
      return;
    }
    dense_.evaluate((t - begin_) / step_, system_->size(), out.data());
  }

  /// Passes end(): switches what ended the step, then takes the next one. Returns false when the step cannot
  /// be made small enough (the system is not finite).
  bool extend() {
    open_step();
    if (!step()) return false;
    Samples g;
    if (system_->guard_count() > 0)
      for (int p = 0; p <= parts; ++p) guards_at(p / double{parts}, g[static_cast<std::size_t>(p)]);
    close_step(locate(g));
    return true;
  }

  // For integrators whose steps are taken side by side (sim/models/lanes): `extend` is open_step, tries until judge
  // agrees, then close_step.

  /// Switches what ended the last step; true: something did, so that state and modes are others.
  bool open_step() {
    const bool switched = pending_ != 0;
    if (switched) {
      system_->flip(end_, y_.data(), pending_);
      lock_.note(end_, pending_);
      pending_ = 0;
      first_slope_known_ = false;
    }
    begin_ = end_;
    return switched;
  }
  double tolerance() const { return tolerance_; }
  void first_slope(State& out) {
    system_->derivative(begin_, y_.data(), out.data());
    ++evaluations_;
  }
  /// Of a try of length h: taken, or next_step() is the length of the next try. `rejected`: one failed before it.
  bool judge(double h, double error, bool rejected) {
    evaluations_ += 6;
    ++steps_;
    const double factor = 0.9 * std::pow(std::max(error, 1e-10), -0.2);
    if (error <= 1) {
      step_ = h;
      next_step_ =
          std::clamp(h * std::clamp(factor, 0.2, rejected ? 1.0 : 5.0), smallest_step, largest_step_);
      return true;
    }
    next_step_ = std::max(h * std::clamp(std::isfinite(error) ? factor : 0.1, 0.1, 0.9), smallest_step);
    return false;
  }
  /// What a step taken elsewhere led to: `fill` writes its dense output and the state at its end, of size() states.
  template <class Fill>
  void take(Fill fill) {
    fill(dense_, y_);
    first_slope_known_ = false;
  }
  static constexpr int parts = 4;  ///< of a step, between which guards are looked at
  using Samples = std::array<Guards, parts + 1>;
  /// Share of the step before the first guard turns negative; 1 = none. Its dense output is there, and `g` holds the
  /// guards at its parts.
  double locate_zero(const Samples& g) { return locate(g); }
  void close_step(double share) {
    if (share < 1) {
      State landed;
      dense_.evaluate(share, system_->size(), landed.data());
      y_ = landed;
      end_ = begin_ + share * step_;
      first_slope_known_ = false;
      next_step_ = std::max(0.5 * std::min(next_step_, step_), smallest_step);
    } else {
      end_ = begin_ + step_;
    }
  }

 private:
  bool step() {
    const int n = system_->size();
    if (!first_slope_known_) {
      system_->derivative(begin_, y_.data(), tableau_.slope(0));
      ++evaluations_;
    }
    for (bool rejected = false;; rejected = true) {
      const double h = next_step_;
      const double error = tableau_.attempt(*system_, begin_, h, n, y_.data(), tolerance_);
      if (judge(h, error, rejected)) {
        tableau_.dense(h, n, y_.data(), dense_);
        std::copy_n(tableau_.result(), n, y_.data());
        std::swap_ranges(tableau_.slope(0), tableau_.slope(0) + n, tableau_.slope(6));
        first_slope_known_ = true;
        return true;
      }
      if (h <= smallest_step) return false;
    }
  }

  void guards_at(double share, Guards& g) const {
    State y;
    dense_.evaluate(share, system_->size(), y.data());
    system_->guards(begin_ + share * step_, y.data(), g.data());
  }

  /// One guard alone, where the system can tell it.
  double guard_at(int k, double share) const {
    State y;
    dense_.evaluate(share, system_->size(), y.data());
    if constexpr (requires { system_->guard(k, 0.0, y.data()); }) {
      return system_->guard(k, begin_ + share * step_, y.data());
    } else {
      Guards g;
      system_->guards(begin_ + share * step_, y.data(), g.data());
      return g[static_cast<std::size_t>(k)];
    }
  }

  bool locked(int k) const { return lock_.holds(k, begin_); }

  /// Share of the step before the first guard turns negative; 1 = none. Sets `pending_`.
  double locate(const Samples& g) {
    constexpr double none = 2;
    const int n = system_->guard_count();
    if (n == 0) return 1;
    double first = none;
    for (int k = 0; k < n; ++k) {
      if (locked(k)) continue;
      const auto value = [&](int p) { return g[static_cast<std::size_t>(p)][static_cast<std::size_t>(k)]; };
      double low = 0;
      double high = none;
      for (int p = 1; p <= parts && high > 1; ++p)
        if (value(p) < 0) {
          low = (p - 1) / double{parts};
          high = p / double{parts};
        }
      for (int p = 1; p < parts && high > 1;
           ++p)  // a dip between the samples: look at the vertex of the parabola
        if (dips_low(value(p - 1), value(p), value(p + 1))) {
          const double curvature = value(p - 1) - 2 * value(p) + value(p + 1);
          const double shift = 0.5 * (value(p - 1) - value(p + 1)) / curvature;
          const double vertex = (p + std::clamp(shift, -0.5, 0.5)) / parts;
          if (guard_at(k, vertex) < 0) {
            low = (p - 1) / double{parts};
            high = vertex;
          }
        }
      if (high <= 1 && low < first) first = std::min(first, root(k, low, high));
    }
    if (first == none) return 1;
    Guards at;
    guards_at(first, at);
    for (int k = 0; k < n; ++k)
      if (!locked(k) && at[static_cast<std::size_t>(k)] < 0) pending_ |= std::uint64_t{1} << k;
    return first;
  }

  /// Smallest share found at which guard k is negative: false position with halving, kept on the negative
  /// side.
  double root(int k, double low, double high) const {
    double g_low = std::max(guard_at(k, low), 0.0);
    double g_high = guard_at(k, high);
    int side = 0;
    for (int i = 0; i < 100 && high - low > 4e-16 * std::max(high, 1e-3); ++i) {
      double middle =
          (i % 8 == 7 || g_low <= 0) ? 0.5 * (low + high) : low + (high - low) * g_low / (g_low - g_high);
      if (middle <= low || middle >= high) middle = 0.5 * (low + high);
      if (middle <= low || middle >= high) break;
      const double g = guard_at(k, middle);
      if (g < 0) {
        high = middle;
        g_high = g;
        if (side == -1) g_low *= 0.5;
        side = -1;
      } else {
        low = middle;
        g_low = g;
        if (side == 1) g_high *= 0.5;
        side = 1;
      }
    }
    return high;
  }

  System* system_;
  double tolerance_;
  double largest_step_;
  DormandPrince<System::capacity> tableau_;
  DenseOutput<System::capacity> dense_;
  State y_{};  ///< at end_
  double begin_ = 0;
  double end_ = 0;
  double step_ = 0;  ///< length the dense output was made for, >= end_ - begin_
  double next_step_ = 0;
  bool first_slope_known_ = false;
  std::uint64_t pending_ = 0;
  ChatterLock<double, System::guard_capacity> lock_;
  std::int64_t evaluations_ = 0;
  std::int64_t steps_ = 0;
};

}  // namespace powbench::sim
