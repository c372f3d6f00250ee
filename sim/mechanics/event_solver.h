#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sim/mechanics/chatter_lock.h"
#include "sim/mechanics/crossing.h"
#include "sim/mechanics/dop853.h"
#include "sim/mechanics/followed_step.h"

/// Integration of a system with modes: order 8 between events, each event located and landed upon.

namespace powbench::sim {

/// Event-locating integrator over a `System` with
///   all that `FollowedStep` asks for
///   static constexpr int guard_capacity (<= 64)
///   int guard_count(); int smooth_guards()
///   void guards(Real t, const Real* y, const Real* dy, Guards&)     dy == nullptr: curves are not needed
///   Real guard(int k, Real t, const Real* y, Real& rate)            one of them; rate only of a smooth one
///   void flip(Real& t, Real* y, std::uint64_t which)    switches modes, and may jump states and time
///   int choose_root(const Guards&, const Real* y, Real step, Real& root)    contact to follow, its guard, or -1
///
/// A step may overshoot: modes are locked while it lasts. The earliest crossing is bracketed on the quintic of
/// each guard and refined on the dense output. A step of that length, repeated, is the start of the next one: the
/// dense output has an error of about the tolerance inside a step, a thousand times that at the end of a step, and
/// energy lost there is not recovered. (The end of the followed contact and guards that are only compared in sign
/// take the dense output.) Everything that crosses within `simultaneous` switches together, so the order of the
/// guards does not matter. A guard that keeps switching is ignored for a while that doubles (`ChatterLock`); a step
/// ends where a lock does.
template <class System>
class EventSolver : public FollowedStep<System> {
  using Step = FollowedStep<System>;

 public:
  using Real = typename System::Real;
  using GuardSet = Guards<Real, System::guard_capacity>;
  using Step::capacity;
  static constexpr Real simultaneous = Real(1e-13L);  ///< s

  /// Everything a run remembers between two steps: copying it is a restart that continues bit for bit.
  struct Memory : Step::StepMemory {
    std::uint64_t pending = 0;  ///< guards that ended the last step
    ChatterLock<Real, System::guard_capacity> lock;
    std::int64_t events = 0;
  };

  EventSolver(System& system, Real tolerance, Real largest_step) : Step(system, tolerance, largest_step) {}

  /// Starts anew at (t, y). The first step is tried with `step` s.
  void restart(Real t, const Real* y, Real step) {
    Step::restart(t, y, step);
    pending_ = 0;
    guards_known_ = false;
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

  std::int64_t events() const { return events_; }
  /// Steps have been kept short by stability, not by accuracy, for a while, and no event ended the last one.
  bool stiff() const { return m_.stiff_steps >= 15 && pending_ == 0; }

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
    int chosen = system_->choose_root(sets_[now_], m_.y, m_.step, root);
    // the zero of a locked guard ends no step, and beyond that of its root the time would run backwards
    if (chosen >= 0 && locked(chosen)) chosen = -1;
    follow(chosen, root);
    if (!Step::step(lock_.room(begin_))) return false;
    land();
    return true;
  }

 private:
  using Step::begin_, Step::covered_, Step::dense_, Step::k_, Step::length_, Step::m_, Step::n_,
      Step::near_end_, Step::rows_, Step::start_, Step::system_, Step::work_;
  using Step::derivative, Step::follow, Step::followed, Step::own_slope, Step::prepare_dense, Step::stage;

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

  GuardSet sets_[2]{};  ///< of the begin and of the end of the step
  int now_ = 0;
  bool guards_known_ = false;
  StepEnds<Real> ends_{};
  Crossing<Real> brackets_[System::guard_capacity];
  std::uint64_t pending_ = 0;
  ChatterLock<Real, System::guard_capacity> lock_;
  std::int64_t events_ = 0;
};

}  // namespace powbench::sim
