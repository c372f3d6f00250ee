#pragma once

#include <algorithm>
#include <cstdint>

namespace powbench::sim {

/// Keeps accumulating events from stopping the clock: a guard that switches more than `count` times, each within
/// `window` of the last, is ignored for that long; for twice as long if it does so again soon, up to `longest`.
template <class Real, int Guards>
class ChatterLock {
 public:
  static constexpr Real window = Real(1e-9L);   ///< s
  static constexpr Real longest = Real(1e-4L);  ///< s
  static constexpr int count = 6;

  ChatterLock() {
    std::fill_n(last_, Guards, Real(-1e300L));
    std::fill_n(until_, Guards, Real(-1e300L));
    std::fill_n(length_, Guards, window);
  }
  bool holds(int guard, Real t) const { return t < until_[guard]; }

  /// Time from t to the end of the lock that ends first, at least `window` / 1000; none: 1e300. A step that begins
  /// inside a lock ends there: beyond it the guard counts again.
  Real room(Real t) const {
    Real first = Real(1e300L);
    if (t >= last_end_) return first;
    for (const Real end : until_)
      if (end > t) first = std::min(first, end - t);
    return std::max(first, window / 1000);
  }

  /// The guards whose bits are set switch at t.
  void note(Real t, std::uint64_t which) {
    for (int k = 0; k < Guards; ++k) {
      if ((which >> k & 1U) == 0) continue;
      flips_[k] = t - last_[k] < window ? flips_[k] + 1 : 0;
      last_[k] = t;
      if (flips_[k] <= count) continue;
      const bool again = t - until_[k] < 100 * length_[k];
      length_[k] = again ? std::min(2 * length_[k], longest) : window;
      until_[k] = t + length_[k];
      last_end_ = std::max(last_end_, until_[k]);
      flips_[k] = 0;
    }
  }

 private:
  int flips_[Guards] = {};
  Real last_[Guards];
  Real until_[Guards];
  Real length_[Guards];
  Real last_end_ = Real(-1e300L);
};

}  // namespace powbench::sim
