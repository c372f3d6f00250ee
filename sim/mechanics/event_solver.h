#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "sim/mechanics/chatter_lock.h"
#include "sim/mechanics/crossing.h"
#include "sim/mechanics/dop853.h"

/// Integration of a system with modes: order 8 between events, each event located and landed upon.

namespace powbench::sim {

/// Event-locating integrator over a `System` with
///   using Real; static constexpr int capacity, guard_capacity (<= 64)
///   int size(); int guard_count(); int smooth_guards()
///   Real scale(int i)                     tolerance of state i is tolerance * scale(i)
///   void derivative(Real t, const Real* y, Real* dy)   per second; may write up to padded(size() + 2) values of dy
///   void guards(Real t, const Real* y, const Real* dy, Guards&)     dy == nullptr: curves are not needed
///   Real guard(int k, Real t, const Real* y, Real& rate)            one of them; rate only of a smooth one
///   void flip(Real& t, Real* y, std::uint64_t which)    switches modes, and may jump states and time
/// and, for contacts whose force has a root of their depth at its beginning and end,
///   int choose_root(const Guards&, const Real* y, Real step, Real& root)    guard of the contact, or -1
///   void follow_root(int guard)           from now on `root` is the square root of that contact's depth
///   void set_root(Real root)
///   Real depth_rate(const Real* y)        m/s, of the followed contact
///   Real root_step(int guard, const Real* y)   length of a first step in s, sqrt(m)^-1 s
///
/// A force k d^1.5 is not smooth where d begins and ends, and no high order survives that. While a contact is
/// followed, the independent variable s has dt = w ds with w = sqrt(d), and w is a state: dw/ds = d'/2. Then
/// d^1.5 = w^3, the touch is a simple zero of w, and everything is smooth through both ends of the contact.
///
/// A step may overshoot: modes are locked while it lasts. The earliest crossing is bracketed on the quintic of
/// each guard and refined on the dense output. A step of that length, repeated, is the start of the next one: the
/// dense output has an error of about the tolerance inside a step, a thousand times that at the end of a step, and
/// energy lost there is not recovered. (The end of the followed contact and guards that are only compared in sign
/// take the dense output.) Everything that crosses within `simultaneous` switches together, so the order of the
/// guards does not matter. A guard that keeps switching is ignored for a while that doubles (`ChatterLock`); a step
/// ends where a lock does.
template <class System>
class EventSolver {
 public:
  using Real = typename System::Real;
  using GuardSet = Guards<Real, System::guard_capacity>;
  static constexpr int capacity = dop853::padded(System::capacity + 2);

  static constexpr Real smallest_step = Real(1e-13L);  ///< s, below: give up
  static constexpr Real simultaneous = Real(1e-13L);   ///< s

  /// What the steps remember from one to the next.
  struct StepMemory {
    alignas(dop853::alignment) Real y[capacity] = {};      ///< states, time, root
    alignas(dop853::alignment) Real slope[capacity] = {};  ///< dy/dt at y
    Real time = 0;
    Real step = 0;                 ///< s, next step without a followed contact
    Real root_step = 0;            ///< next step in s of the followed contact
    Real root_share = Real(0.2L);  ///< first step of a contact, over its natural length
    Real last_error = Real(1e-4L);
    Real error_time = 0;  ///< s
    int root = -1;
    bool slope_known = false;
    int stiff_steps = 0;  ///< in a row
    std::int64_t evaluations = 0;
    std::int64_t steps = 0;
    std::int64_t rejected = 0;
  };

  /// Everything a run remembers between two steps: copying it is a restart that continues bit for bit.
  struct Memory : StepMemory {
    std::uint64_t pending = 0;  ///< guards that ended the last step
    ChatterLock<Real, System::guard_capacity> lock;
    std::int64_t events = 0;
  };

  EventSolver(System& system, Real tolerance, Real largest_step)
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
    pending_ = 0;
    m_.stiff_steps = 0;
    dense_ready_ = guards_known_ = false;
    length_ = 0;
    std::fill_n(inverse_, capacity, Real(0));
    for (int i = 0; i < n_; ++i) inverse_[i] = 1 / (tolerance_ * system_->scale(i));
  }

  Memory memory() const { return {m_, pending_, lock_, events_}; }
  /// Continues from a copy; the system must be the copy that belongs to it. No dense output until the next step.
  void resume(const Memory& memory) {
    restart(memory.time, memory.y, memory.step);
    m_ = memory;
    pending_ = memory.pending;
    lock_ = memory.lock;
    events_ = memory.events;
    system_->follow_root(m_.root);
  }

  Real begin() const { return begin_; }  ///< s: the dense output covers [begin, end]
  Real end() const { return m_.time; }
  const Real* end_state() const { return m_.y; }
  std::int64_t evaluations() const { return m_.evaluations; }
  std::int64_t steps() const { return m_.steps; }
  std::int64_t rejected() const { return m_.rejected; }
  std::int64_t events() const { return events_; }
  /// Steps have been kept short by stability, not by accuracy, for a while, and no event ended the last one.
  bool stiff() const { return m_.stiff_steps >= 15 && pending_ == 0; }
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

  /// Passes end(): switches what ended the step, then takes the next one. False: the step cannot be made small
  /// enough.
  bool extend() {
    if (pending_ != 0) {
      lock_.note(m_.time, pending_);
      events_ += 1;
      system_->flip(m_.time, m_.y, pending_);
      pending_ = 0;
      m_.slope_known = guards_known_ = false;
    }
    begin_ = m_.time;
    if (!m_.slope_known) {
      derivative(m_.time, m_.y, m_.slope);
      m_.slope_known = true;
    }
    if (!guards_known_) system_->guards(begin_, m_.y, m_.slope, sets_[now_]);
    guards_known_ = false;
    Real root = 0;
    const int chosen = system_->choose_root(sets_[now_], m_.y, m_.step, root);
    follow(chosen, root);
    if (!step(lock_.room(begin_))) return false;
    land();
    return true;
  }

 private:
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

  /// The quintic of guard k over the step just taken.
  Bernstein<Real> curve(int k) const {
    const GuardSet& g0 = sets_[now_];
    const GuardSet& g1 = sets_[1 - now_];
    if (k == m_.root) {
      const Real a = start_[n_ + 1];
      const Real b = m_.y[n_ + 1];
      return quintic(a, length_ * g0.rate[k] / 2, length_ * length_ * a * g0.curve[k] / 2, b,
                     length_ * g1.rate[k] / 2, length_ * length_ * b * g1.curve[k] / 2);
    }
    return quintic(g0.value[k], ends_.first * g0.rate[k],
                   ends_.first * ends_.first * g0.curve[k] + ends_.first_bend * g0.rate[k], g1.value[k],
                   ends_.last * g1.rate[k],
                   ends_.last * ends_.last * g1.curve[k] + ends_.last_bend * g1.rate[k]);
  }

  void set_ends() {
    if (!followed()) {
      ends_ = {length_, 0, length_, 0};
      return;
    }
    ends_ = {length_ * start_[n_ + 1], length_ * k_[n_ + 1] * length_, length_ * m_.y[n_ + 1],
             length_ * k_[12 * capacity + n_ + 1] * length_};
  }

  bool locked(int k) const { return lock_.holds(k, begin_); }

  /// Ends the step at the earliest crossing, if there is one.
  void land() {
    GuardSet& g1 = sets_[1 - now_];
    system_->guards(m_.time, m_.y, m_.slope, g1);
    set_ends();
    const std::uint64_t suspects = suspicious(g1);
    if (suspects == 0) {
      now_ = 1 - now_;
      guards_known_ = true;
      return;
    }
    prepare_dense();
    Real first = 2;
    int which = -1;
    const int all = system_->guard_count();
    if (followed() && (suspects >> m_.root & 1U) != 0) {  // beyond its zero the time runs backwards
      first = refine(m_.root, brackets_[m_.root], 1);
      if (first <= 1) which = m_.root;
    }
    for (int k = 0; k < all; ++k) {
      if ((suspects >> k & 1U) == 0 || k == m_.root || brackets_[k].low >= first) continue;
      brackets_[k].high = std::min(brackets_[k].high, first);
      const Real x = refine(k, brackets_[k], std::min(first, Real(1)));
      if (x >= first) continue;
      first = x;
      which = k;
    }
    if (which >= 0) land_at(first, which, suspects);
  }

  /// The guards that may turn negative within the step, with their brackets.
  std::uint64_t suspicious(const GuardSet& g1) {
    const int smooth = system_->smooth_guards();
    const int all = system_->guard_count();
    std::uint64_t found = 0;
    const auto look = [&](int k) {
      if (locked(k)) return;
      brackets_[k] = first_crossing(curve(k));
      if (brackets_[k].found) found |= std::uint64_t{1} << k;
    };
    if (followed()) look(m_.root);
    if (may_cross(dop853::padded(smooth), ends_, sets_[now_], g1)) {
      for (int k = 0; k < smooth; ++k)
        if (k != m_.root) look(k);
    }
    for (int k = smooth; k < all; ++k) {
      if (locked(k)) continue;
      const Real at = g1.value[k] < 0 ? Real(1) : system_->dip(k, sets_[now_], g1, ends_);
      if (at > 1) continue;
      brackets_[k] = {true, 0, at};
      found |= std::uint64_t{1} << k;
    }
    return found;
  }

  void land_at(Real share, int which, std::uint64_t suspects) {
    const bool by_step = which < system_->smooth_guards() && which != m_.root;
    if (!by_step || !step_to(share, which)) {
      dop853::dense_state(rows_, share, start_, dense_, capacity, m_.y);
      m_.time = followed() ? begin_ + m_.y[n_] : begin_ + share * length_;
      system_->set_root(m_.y[n_ + 1]);
    }
    covered_ = share;
    GuardSet& g = sets_[1 - now_];
    system_->guards(m_.time, m_.y, nullptr, g);
    pending_ = std::uint64_t{1} << which;
    const int smooth = system_->smooth_guards();
    for (int k = 0; k < system_->guard_count(); ++k) {
      if ((suspects >> k & 1U) == 0) continue;
      const Real value = k == m_.root ? m_.y[n_ + 1] : g.value[k];
      const bool near = k < smooth && g.rate[k] < 0 && k != m_.root && value <= -g.rate[k] * simultaneous;
      if (value < 0 || near) pending_ |= std::uint64_t{1} << k;
    }
    m_.slope_known = false;
    m_.last_error = Real(1e-4L);
  }

  /// Repeats the step up to a share of it and moves the rest of the way to the zero of smooth guard k, by the midpoint
  /// rule. False: the way is too long for that.
  bool step_to(Real share, int k) {
    const Real h = share * length_;
    for (int row = 1; row < dop853::stages; ++row) stage(row, h);
    Real* y = near_end_;
    dop853::argument(12, rows_, h, start_, k_, capacity, y);
    const Real t = followed() ? begin_ + y[n_] : begin_ + h;
    const Real root = y[n_ + 1];
    system_->set_root(root);
    Real rate = 0;
    const Real value = system_->guard(k, t, y, rate);
    if (followed()) rate *= root;
    const Real rest = -value / rate;
    if (!(rate < 0 && std::fabs(rest) < length_ / 8)) return false;
    Real* row = k_ + 12 * capacity;
    own_slope(t, y, row);
    std::copy_n(y, rows_, m_.y);
    for (int i = 0; i < rows_; ++i) y[i] += rest / 2 * row[i];
    own_slope(followed() ? begin_ + y[n_] : t + rest / 2, y, row);
    for (int i = 0; i < rows_; ++i) m_.y[i] += rest * row[i];
    m_.time = followed() ? begin_ + m_.y[n_] : t + rest;
    system_->set_root(m_.y[n_ + 1]);
    return true;
  }

  /// Value of guard k at a share of the step, and its slope per share where it is known.
  Real guard_at(int k, Real share, Real& slope) {
    Real* y = work_;
    dop853::dense_state(rows_, share, start_, dense_, capacity, y);
    const Real root = y[n_ + 1];
    const Real t = followed() ? begin_ + y[n_] : begin_ + share * length_;
    system_->set_root(root);
    Real rate = 0;
    const Real value = system_->guard(k, t, y, rate);
    slope = length_ * rate * (k == m_.root ? Real(0.5L) : followed() ? root : Real(1));
    return k == m_.root ? root : value;
  }

  /// First share at which guard k is negative on the dense output, 2 if it is nowhere.
  Real refine(int k, const Crossing<Real>& bracket, Real most) {
    return first_negative(bracket, most, [&](Real share, Real& slope) { return guard_at(k, share, slope); });
  }

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
  GuardSet sets_[2]{};  ///< of the begin and of the end of the step
  int now_ = 0;
  bool guards_known_ = false;
  StepEnds<Real> ends_{};
  Crossing<Real> brackets_[System::guard_capacity];
  std::uint64_t pending_ = 0;
  ChatterLock<Real, System::guard_capacity> lock_;
  std::int64_t events_ = 0;
  Real begin_ = 0;
  Real length_ = 0;   ///< of the step in its own variable
  Real covered_ = 1;  ///< share of it up to the event that ended it
  bool dense_ready_ = false;
  bool fresh_ = false;
};

}  // namespace powbench::sim
