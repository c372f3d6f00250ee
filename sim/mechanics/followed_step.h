#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sim/mechanics/dop853.h"

/// One step of order 8, in time or along a followed contact.

namespace powbench::sim {

/// Steps of adaptive length over a `System` with
///   using Real; static constexpr int capacity
///   int size()
///   Real scale(int i)                     tolerance of state i is tolerance * scale(i)
///   void derivative(Real t, const Real* y, Real* dy)   per second; may write up to padded(size() + 2) values of dy
/// and, for contacts whose force has a root of their depth at its beginning and end,
///   void follow_root(int guard)           from now on `root` is the square root of that contact's depth
///   void set_root(Real root)
///   Real depth_rate(const Real* y)        m/s, of the followed contact
///   Real root_step(int guard, const Real* y)   length of a first step in s, sqrt(m)^-1 s
///
/// A force k d^1.5 is not smooth where d begins and ends, and no high order survives that. While a contact is
/// followed, the independent variable s has dt = w ds with w = sqrt(d), and w is a state: dw/ds = d'/2. Then
/// d^1.5 = w^3, the touch is a simple zero of w, and everything is smooth through both ends of the contact.
template <class System>
class FollowedStep {
 public:
  using Real = typename System::Real;
  static constexpr int capacity = dop853::padded(System::capacity + 2);

  static constexpr Real smallest_step = Real(1e-13L);  ///< s, below: give up

  /// What the steps remember from one to the next.
  struct StepMemory {
    alignas(dop853::alignment) Real y[capacity] = {};      ///< states, time, root
    alignas(dop853::alignment) Real slope[capacity] = {};  ///< dy/dt at y
    Real time = 0;
    Real step = 0;                 ///< s, next step without a followed contact
    Real root_step = 0;            ///< next step in s of the followed contact
    Real root_share = Real(0.2L);  ///< first step of a contact, over its natural length
    Real last_error = Real(1e-4L);
    int root = -1;
    bool slope_known = false;
    int stiff_steps = 0;  ///< in a row
    std::int64_t evaluations = 0;
    std::int64_t steps = 0;
    std::int64_t rejected = 0;
  };

  Real begin() const { return begin_; }  ///< s: the dense output covers [begin, end]
  Real end() const { return m_.time; }
  const Real* end_state() const { return m_.y; }
  std::int64_t evaluations() const { return m_.evaluations; }
  std::int64_t steps() const { return m_.steps; }
  std::int64_t rejected() const { return m_.rejected; }
  Real last_step() const { return m_.time - begin_; }

  /// State at `t` in [begin, end]; writes padded(size() + 2) values. `out` needs no alignment of its own.
  void state(Real t, Real* out) {
    if (t >= m_.time) {
      std::copy_n(m_.y, rows_, out);
      return;
    }
    prepare_dense();
    alignas(dop853::alignment) Real y[capacity];
    dop853::dense_state(rows_, share_of(t), start_, dense_, capacity, y);
    std::copy_n(y, rows_, out);
  }

 protected:
  FollowedStep(System& system, Real tolerance, Real largest_step)
      : system_(&system), tolerance_(tolerance), largest_step_(largest_step) {}

  /// Starts anew at (t, y). The first step is tried with `step` s.
  void restart(Real t, const Real* y, Real step) {
    n_ = system_->size();
    rows_ = dop853::padded(n_ + 2);
    std::fill_n(m_.y, capacity, Real(0));
    std::copy_n(y, n_, m_.y);
    m_.time = begin_ = t;
    m_.step = std::min(step, largest_step_);
    m_.root = -1;
    m_.slope_known = false;
    m_.stiff_steps = 0;
    dense_ready_ = false;
    length_ = 0;
    std::fill_n(inverse_, capacity, Real(0));
    for (int i = 0; i < n_; ++i) inverse_[i] = 1 / (tolerance_ * system_->scale(i));
  }

  void derivative(Real t, const Real* y, Real* dy) {
    system_->derivative(t, y, dy);
    ++m_.evaluations;
  }
  bool followed() const { return m_.root >= 0; }

  /// The next step follows the contact `chosen`, whose depth has this root, or none (-1). Decides how long it is tried.
  void follow(int chosen, Real root) {
    if (chosen < 0) {
      m_.root = -1;
    } else {
      if (chosen != m_.root) {
        const Real natural = system_->root_step(chosen, m_.y) * m_.root_share;
        m_.root_step = root > 0 ? std::min(natural, m_.step / root) : natural;
        m_.root = chosen;
        fresh_ = true;
      }
      m_.y[n_ + 1] = root;
    }
    system_->follow_root(m_.root);
    if (!followed()) m_.y[n_ + 1] = 0;
    m_.y[n_] = 0;  // time within the step
    inverse_[n_] = followed() ? 1 / (tolerance_ * Real(1e-3L)) : Real(0);
    inverse_[n_ + 1] = followed() ? 1 / (tolerance_ * Real(0.1L)) : Real(0);
  }

  /// Slope in the independent variable of the step, from the one in time.
  void slope_row(const Real* per_second, Real root, const Real* y, Real* row) {
    for (int i = 0; i < rows_; ++i) row[i] = root * per_second[i];
    row[n_] = root;
    row[n_ + 1] = system_->depth_rate(y) / 2;
    for (int i = n_ + 2; i < rows_; ++i) row[i] = 0;
  }

  void stage(int row, Real h) {
    Real* y = work_;
    dop853::argument(row, rows_, h, start_, k_, capacity, y);
    if (row == dop853::stages - 1) std::copy_n(y, rows_, near_end_);
    const Real t = followed() ? begin_ + y[n_] : begin_ + static_cast<Real>(dop853::c[row]) * h;
    own_slope(t, y, k_ + row * capacity);
  }

  /// Slope in the independent variable of the step.
  void own_slope(Real t, const Real* y, Real* row) {
    const Real root = y[n_ + 1];
    if (followed()) system_->set_root(root);
    derivative(t, y, row);
    if (followed())
      slope_row(row, root, y, row);
    else
      plain_row(row);
  }
  void plain_row(Real* row) {
    row[n_] = 1;
    for (int i = n_ + 1; i < rows_; ++i) row[i] = 0;
  }

  /// A step of length h, cut to `most` s, to first order.
  Real limit(Real h, Real most) const {
    if (!followed()) return std::min(h, most);
    const Real root = start_[n_ + 1];
    const Real bend = std::fabs(k_[n_ + 1]) / 2;
    return h * (root + bend * h) > most ? most / (root + bend * h) : h;
  }

  /// One step from (end(), m_.y) of at most `room` s. False: it cannot be made small enough.
  bool step(Real room) {
    std::copy_n(m_.y, rows_, start_);
    if (followed()) {
      system_->set_root(start_[n_ + 1]);
      slope_row(m_.slope, start_[n_ + 1], start_, k_);
    } else {
      std::copy_n(m_.slope, rows_, k_);
      plain_row(k_);
    }
    const Real asked = followed() ? m_.root_step : m_.step;
    Real h = limit(asked, std::min(largest_step_, room));
    const bool cut = room < largest_step_ && h < asked;  // says nothing of the step that accuracy allows
    for (bool again = false;; again = true) {
      for (int row = 1; row < dop853::stages; ++row) stage(row, h);
      const Real error = dop853::error(rows_, n_ + (followed() ? 2 : 0), h, k_, capacity, inverse_);
      ++m_.steps;
      if constexpr (requires { system_->tried(true); }) system_->tried(error <= 1);
      if (error <= 1) {
        accept(h, error, again, cut);
        return true;
      }
      ++m_.rejected;
      const Real factor = Real(0.9L) * std::pow(error, Real(-1) / 8);
      h *= std::isfinite(error) ? std::clamp(factor, Real(0.2L), Real(0.9L)) : Real(0.1L);
      if (!(h > smallest_step * (followed() ? Real(1e-3L) : Real(1)))) return false;
    }
  }

  void accept(Real h, Real error, bool again, bool cut) {
    dop853::argument(12, rows_, h, start_, k_, capacity, m_.y);
    length_ = h;
    covered_ = 1;
    m_.time = followed() ? begin_ + m_.y[n_] : begin_ + h;
    const Real root = m_.y[n_ + 1];
    system_->set_root(root);
    derivative(m_.time, m_.y, m_.slope);
    Real* last = k_ + 12 * capacity;
    if (followed()) {
      slope_row(m_.slope, root, m_.y, last);
    } else {
      std::copy_n(m_.slope, rows_, last);
      plain_row(last);
    }
    dense_ready_ = false;
    if (cut && !again) return;
    const Real small = std::max(error, Real(1e-10L));
    Real factor = Real(0.9L) * std::pow(small, Real(-0.7L) / 8) * std::pow(m_.last_error, Real(0.4L) / 8);
    factor = std::clamp(factor, Real(0.2L), again ? Real(1) : Real(5));
    m_.last_error = std::max(error, Real(1e-4L));
    if (followed()) {
      m_.root_step = h * factor;
      if (fresh_)
        m_.root_share = std::clamp(m_.root_share * (h * factor / first_root_step()), Real(0.02L), Real(3));
      fresh_ = false;
    } else {
      m_.step = std::min(h * factor, largest_step_);
      watch_stiffness(h);
    }
  }

  /// h |lambda| from two slopes at the end of the step, at slightly different states; 6.1 is the bound of stability.
  void watch_stiffness(Real h) {
    Real slopes = 0;
    Real states = 0;
    for (int i = 0; i < n_; ++i) {
      const Real f = (m_.slope[i] - k_[11 * capacity + i]) * inverse_[i];
      const Real y = (m_.y[i] - near_end_[i]) * inverse_[i];
      slopes += f * f;
      states += y * y;
    }
    m_.stiff_steps = h * h * slopes > Real(2.5L) * Real(2.5L) * states ? m_.stiff_steps + 1 : 0;
  }
  Real first_root_step() const { return system_->root_step(m_.root, start_) * m_.root_share; }

  /// The last slopes, which only the dense output needs.
  void prepare_dense() {
    if (dense_ready_) return;
    const Real root = m_.y[n_ + 1];
    for (int row = 13; row < dop853::slopes; ++row) stage(row, length_);
    alignas(dop853::alignment) Real y1[capacity];
    dop853::argument(12, rows_, length_, start_, k_, capacity, y1);
    dop853::dense_rows(rows_, length_, start_, y1, k_, capacity, dense_);
    system_->set_root(root);
    dense_ready_ = true;
  }

  /// Share of the step at time t; in s the time is a state and grows monotonically.
  Real share_of(Real t) {
    if (!followed()) return (t - begin_) / length_;
    Real low = 0;
    Real high = covered_;  // beyond the zero of the root the time runs backwards
    for (int i = 0; i < 60 && high - low > Real(1e-17L); ++i) {
      const Real x = (low + high) / 2;
      alignas(dop853::alignment) Real y[capacity];
      dop853::dense_state(rows_, x, start_, dense_, capacity, y);
      (begin_ + y[n_] < t ? low : high) = x;
    }
    return high;
  }

  System* system_;
  Real tolerance_;
  Real largest_step_;
  int n_ = 0;
  int rows_ = 0;
  StepMemory m_;
  alignas(dop853::alignment) Real start_[capacity] = {};  ///< states at begin_
  alignas(dop853::alignment) Real inverse_[capacity] = {};
  alignas(dop853::alignment) Real k_[dop853::slopes * capacity] = {};
  alignas(dop853::alignment) Real dense_[7 * capacity] = {};
  alignas(dop853::alignment) Real near_end_[capacity] = {};  ///< argument of slope 11
  /// Argument of the current slope. Beyond rows_ it stays zero: systems may read there.
  alignas(dop853::alignment) Real work_[capacity] = {};
  Real begin_ = 0;
  Real length_ = 0;   ///< of the step in its own variable
  Real covered_ = 1;  ///< share of it up to the event that ended it
  bool dense_ready_ = false;
  bool fresh_ = false;
};

}  // namespace powbench::sim
