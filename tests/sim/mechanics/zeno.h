#pragma once

#include <cmath>

/// Accumulating impacts of a rigid law: v+ = -e v-. Under a constant acceleration a towards the wall the intervals
/// 2 v/a shrink by e, and infinitely many of them end at a finite time
///
///   t_inf = t + 2 v+ / (a (1 - e)).

namespace powbench::sim {

/// Watches the impacts of one contact and says when to jump to their limit.
template <class Real>
class ZenoWatch {
 public:
  ZenoWatch(Real restitution, Real resolution) : e_(restitution), resolution_(resolution) {}

  /// Books an impact at `t` that leaves with `speed` > 0 under `acceleration` > 0 towards the wall. True when two
  /// intervals in a row have shrunk by e and the next is below the resolution: then the contact is closed from
  /// limit() on.
  bool impact(Real t, Real speed, Real acceleration) {
    const Real interval = t - last_;
    const bool shrinks = count_ > 0 && std::fabs(interval - e_ * before_) < Real(1e-3L) * before_;
    in_row_ = shrinks ? in_row_ + 1 : 0;
    before_ = interval;
    last_ = t;
    ++count_;
    if (!(acceleration > 0) || e_ >= 1) return false;
    limit_ = t + 2 * speed / (acceleration * (1 - e_));
    return in_row_ >= 2 && 2 * speed / acceleration < resolution_;
  }
  Real limit() const { return limit_; }
  int impacts() const { return count_; }

 private:
  Real e_;
  Real resolution_;
  Real last_ = 0;
  Real before_ = 0;
  Real limit_ = 0;
  int in_row_ = 0;
  int count_ = 0;
};

}  // namespace powbench::sim
