#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim/mechanics/contact_law.h"
#include "sim/mechanics/event_solver.h"

namespace powbench::sim {

/// Bodies on a line, 0 .. n-1, each with a constant force; neighbours touch at equal positions. With `wall` there is a
/// contact of body 0 against the origin as well (bodies at positive x press away from it).
template <class R, int Bodies>
class Chain {
 public:
  using Real = R;
  static constexpr int capacity = 2 * Bodies;
  static constexpr int guard_capacity = 8;
  using GuardSet = Guards<Real, guard_capacity>;

  std::array<Real, Bodies> mass, force{};
  ContactLaw law;
  bool wall = false;
  int touches = 0;
  std::vector<double> times;
  std::array<bool, 8> pressing{};
  std::array<Real, 8> lambda{};

  int size() const { return capacity; }
  int guard_count() const { return Bodies - 1 + (wall ? 1 : 0); }
  int smooth_guards() const { return guard_count(); }
  Real scale(int i) const { return i < Bodies ? Real(1e-3L) * size_scale : size_scale; }
  Real size_scale = 1;

  Real depth(int c, const Real* q) const {
    if (c == Bodies - 1) return -q[0];
    return q[c] - q[c + 1];
  }
  Real effective(int c) const {
    return c == Bodies - 1 ? mass[0] : 1 / (1 / mass[at(c)] + 1 / mass[at(c + 1)]);
  }
  void derivative(Real, const Real* y, Real* dy) const {
    for (int i = 0; i < Bodies; ++i) {
      dy[i] = y[Bodies + i];
      dy[Bodies + i] = force[at(i)];
    }
    for (int c = 0; c < guard_count(); ++c) {
      if (!pressing[at(c)]) continue;
      const Real rate = depth(c, y + Bodies);
      const Real d = c == followed_ ? root_ * root_ : std::max(depth(c, y), Real(0));
      Real f = elastic_force(law, d);
      if (c == followed_) f = static_cast<Real>(law.stiffness) * root_ * root_ * root_;
      f *= 1 + lambda[at(c)] * rate;
      if (law.exponent == 1) f = static_cast<Real>(law.stiffness) * depth(c, y) * (1 + lambda[at(c)] * rate);
      if (c == Bodies - 1) {
        dy[Bodies] += f;
      } else {
        dy[Bodies + c] -= f;
        dy[Bodies + c + 1] += f;
      }
    }
    for (int i = 0; i < Bodies; ++i) dy[Bodies + i] /= mass[at(i)];
  }
  void guards(Real, const Real* y, const Real* dy, GuardSet& g) const {
    for (int c = 0; c < guard_count(); ++c) {
      g.value[c] = guard(c, 0, y, g.rate[c]);
      if (dy != nullptr) g.curve[c] = (pressing[at(c)] ? 1 : -1) * depth(c, dy + Bodies);
    }
    for (int c = guard_count(); c < guard_capacity; ++c) g.value[c] = 1;
  }
  Real guard(int k, Real, const Real* y, Real& rate) const {
    const Real sign = pressing[at(k)] ? 1 : -1;
    rate = sign * depth(k, y + Bodies);
    return sign * depth(k, y);
  }
  void flip(Real& t, Real* y, std::uint64_t which) {
    for (int c = 0; c < guard_count(); ++c) {
      if ((which >> c & 1U) == 0) continue;
      pressing[at(c)] = !pressing[at(c)];
      touches += pressing[at(c)];
      times.push_back(static_cast<double>(t));
      if (pressing[at(c)])
        lambda[at(c)] = static_cast<Real>(law.hysteresis(static_cast<double>(depth(c, y + Bodies))));
    }
  }
  Real dip(int, const GuardSet&, const GuardSet&, const StepEnds<Real>&) const {
    return 2;
  }  // no plain guard
  int choose_root(const GuardSet& g, const Real*, Real step, Real& root) const {
    if (law.exponent != 1.5) return -1;
    Real soonest = 3 * step;
    int best = -1;
    for (int c = 0; c < guard_count(); ++c) {
      const Real rate = std::fabs(g.rate[c]);
      if (!pressing[at(c)] || rate < Real(1e-9L) || std::max(g.value[c], Real(0)) >= soonest * rate) continue;
      soonest = std::max(g.value[c], Real(0)) / rate;
      root = std::sqrt(std::max(g.value[c], Real(0)));
      best = c;
    }
    return best;
  }
  void follow_root(int c) { followed_ = c; }
  void set_root(Real r) { root_ = r; }
  Real depth_rate(const Real* y) const { return followed_ < 0 ? Real(0) : depth(followed_, y + Bodies); }
  Real root_step(int c, const Real* y) const {
    return root_scale(static_cast<Real>(law.stiffness), effective(c), depth(c, y), depth(c, y + Bodies));
  }
  double energy(const Real* y) const {
    Real e = 0;
    for (int i = 0; i < Bodies; ++i)
      e += mass[at(i)] * y[Bodies + i] * y[Bodies + i] / 2 - force[at(i)] * y[i];
    for (int c = 0; c < guard_count(); ++c) {
      const Real d = depth(c, y);
      if (d > 0) e += elastic_force(law, d) * d / static_cast<Real>(law.exponent + 1);
    }
    return static_cast<double>(e);
  }

 private:
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int followed_ = -1;
  Real root_ = 0;
};

}  // namespace powbench::sim
