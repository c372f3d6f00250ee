#pragma once

#include <array>

#include "firmware/mains_ring.h"

/// Is the mains still the waveform it was one cycle ago, and if not, has its phase moved?

namespace powbench::firmware {

/// d = x(t) - x(t - one cycle), averaged over a millisecond: offset, harmonics and notches cancel, what is above
/// 1 kHz is averaged out, and a jump, a dip or a step of the frequency stands out within a fraction of a cycle. Judged
/// by d over the last millisecond and by its rms over the last ten; the limit of the latter is three times what is
/// usual on this mains, between two bounds.
///
/// Over the last cycle, and over its newer half, d is split into q cos of the fundamental and a rest: a jump of the
/// phase is a q and soon nothing else; a tone that comes or goes, or another amplitude, is a rest.
class CycleCompare {
 public:
  static constexpr int blocks = 10;             ///< of one millisecond
  static constexpr int longest_cycle = 24;      ///< blocks
  static constexpr float sudden_limit = 0.10F;  ///< of |d| over one block, of nominal amplitude
  static constexpr float lowest_limit = 0.02F, highest_limit = 0.10F;  ///< over all blocks
  static constexpr float least_strange = 0.0035F;  ///< rms of the rest, of nominal amplitude
  static constexpr float slip_limit =
      0.01F;  ///< of q between the cycle and its newer half, of nominal amplitude
  static constexpr float jump_limit = 0.009F;  ///< of |q|, of nominal amplitude: 0.5 deg ...
  static constexpr float jump_leak = 0.3F;     ///< ... and what a rest of this rms may show there,
  static constexpr float step_leak = 0.15F;    ///< or another amplitude

  void reset();
  /// One more sample of the history has become final; `cycle` samples make a cycle. Range: cycle + final_age
  /// + 2 samples in the history.
  void push(const MainsRing& mains, float cycle);
  /// Closes a block of samples. `turns`: phase of the fundamental at its middle; `cycle`: blocks in a cycle, <=
  /// longest_cycle. True when the limits are kept.
  bool judge(float turns, float cycle);
  /// The last five blocks are themselves above the limit, or the rest of the last cycle is far more than usual: the
  /// change is not older than one cycle.
  bool changing() const { return changing_; }
  /// Within the last cycle the wave was so different that anything may have happened.
  bool sudden() const { return sudden_; }
  /// q^2 against what is allowed: beyond 1 the phase may have jumped, once a cycle has passed since the change.
  float evidence() const { return evidence_; }
  /// The same when the whole cycle lies behind the change: another amplitude is then told from the rest (p sin), and
  /// shows little in q.
  float settled() const { return settled_; }
  /// The phase moves on while the cycle passes: its frequency is another.
  bool slips() const { return slips_; }
  /// Square of the jump that |q| beyond what a rest may show there would be, turns^2 for a nominal amplitude.
  float doubt() const;

 private:
  struct Block {
    float change = 0, cosine = 0, sine = 0;
  };
  void split(int cycle);

  float sum_ = 0;
  int samples_ = 0;
  std::array<Block, longest_cycle> ring_{};
  int newest_ = 0;
  float usual_ = highest_limit;  ///< the limit that goes with the last tenth of a second
  float usual_rest_ = 0;         ///< mean square
  float rest_ = 0, jump_ = 0, half_rest_ = 0, half_explained_ = 0;
  float step_ = 0, other_ = 0;  ///< p, and the mean square of the rest without it
  int since_sudden_ = 0;        ///< blocks, saturates
  float evidence_ = 0, settled_ = 0;
  bool changing_ = false, sudden_ = true, slips_ = false;
};

}  // namespace powbench::firmware
