#pragma once

namespace powbench::sim {

/// For systems without followed contacts.
template <class R>
struct NoRoots {
  using Real = R;
  template <class AnyGuards>
  int choose_root(const AnyGuards&, const Real*, Real, Real&) const {
    return -1;
  }
  void follow_root(int) {}
  void set_root(Real) {}
  Real depth_rate(const Real*) const { return 0; }
  Real root_step(int, const Real*) const { return 0; }
  template <class AnyGuards, class Ends>
  Real dip(int, const AnyGuards&, const AnyGuards&, const Ends&) const {
    return 2;
  }
};

}  // namespace powbench::sim
