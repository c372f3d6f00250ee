#pragma once

/// Equations that stand for one number and for a vector of them (sim/models/lanes) are templates over a class such as
/// this. Those of vectors have internal linkage, and with them all that is made from such a template: each set of
/// instructions has its own.

namespace powbench::sim {

#define POWBENCH_EQUATION inline __attribute__((always_inline))

struct OneNumber {
  using Basis = OneNumber;  ///< what a class that is made from this one counts with
  using Number = double;
  using Stored = double;  ///< a number among the numbers of a system
  using Mask = bool;

  static POWBENCH_EQUATION double at(double stored) { return stored; }
  static POWBENCH_EQUATION double all(double x) { return x; }
  /// One of two; both may be computed.
  template <class A, class B>
  static POWBENCH_EQUATION double choose(bool first, const A& a, const B& b) {
    return first ? a() : b();
  }
};

}  // namespace powbench::sim
