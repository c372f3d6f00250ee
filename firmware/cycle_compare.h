#pragma once

#include <array>

#include "firmware/mains_ring.h"

/// Is the mains still the waveform it was one cycle ago?

namespace powbench::firmware {

/// d = x(t) - x(t - one cycle), averaged over a millisecond: offset, harmonics and notches cancel, what is above
/// 1 kHz is averaged out, and a jump, a dip or a step of the frequency stands out within a fraction of a cycle. Judged
/// by d over the last millisecond and by its rms over the last ten; the limit of the latter is three times what is usual
/// on this mains, between two bounds.
class CycleCompare {
 public:
  static constexpr int blocks = 10;             ///< of one millisecond
  static constexpr float sudden_limit = 0.10F;  ///< of |d| over one block, of nominal amplitude
  static constexpr float lowest_limit = 0.02F, highest_limit = 0.10F;  ///< over all blocks

  void reset();
  /// One more sample of the history has become final; `cycle` samples make a cycle. Range: cycle + final_age
  /// + 2 samples in the history.
  void push(const MainsRing& mains, float cycle);
  /// Closes a block of samples. True when the limits are kept.
  bool judge();
  /// The last five blocks are themselves above the limit: the change is not older than one cycle.
  bool changing() const { return changing_; }

 private:
  float sum_ = 0;
  int samples_ = 0;
  std::array<float, blocks> mean_square_{};
  int newest_ = 0;
  float usual_ = highest_limit;  ///< the limit that goes with the last tenth of a second
  bool changing_ = false;
};

}  // namespace powbench::firmware
