#pragma once

#include <array>

#include "firmware/mains_ring.h"

/// Has the mains just jumped? The quickest look, for an edge that is due now.

namespace powbench::firmware {

/// d = x(t) - x(t - one cycle), without waiting for the repair of notches. An alarm is raised at the third point in a
/// row at which d has one sign and exceeds both `least_limit` and `usual_factor` times its usual rms. It lasts `hold`
/// points: by then CycleCompare, which waits for the repair and a whole millisecond, has judged. A further alarm
/// needs a quiet cycle before it.
class JumpGuard {
 public:
  static constexpr float least_limit = 0.05F;  ///< of nominal amplitude
  static constexpr float usual_factor = 5.5F;
  static constexpr int hold = 40;  ///< points

  void reset();
  /// One more point is in the history. Range: cycle + 2 points in it.
  void push(const MainsRing& mains, float cycle);
  bool suspicious() const { return since_ < hold; }

 private:
  std::array<float, 2> before_{};
  float usual_ = 0;  ///< mean square of d
  int since_ = 0;    ///< points since the alarm, saturates
  int quiet_ = 0;    ///< points since the last that was beyond the limit, saturates
};

}  // namespace powbench::firmware
