#pragma once

#include <array>
#include <cstdint>

/// Is there a tone close to the fundamental? It moves the phase as slowly as the mains itself may, but the amplitude
/// too.

namespace powbench::firmware {

/// A tone of share A beside the fundamental turns about the tip of its phasor: relative amplitude a = A cos wt, phase
/// p = A sin wt (rad), w the beat. Differences over D about the same middle are d p = 2 A sin(wD/2) cos wt and d a =
/// -2 A sin(wD/2) sin wt. So d p goes with a, and the mean squares of d p and d a are equal; neither a mains that
/// moves (no a) nor flicker (no p) does both. Covariances over `memory` updates; the mean square of a is that of the
/// phase error.
class BeatWatch {
 public:
  static constexpr int lag = 20;        ///< updates, D
  static constexpr float memory = 700;  ///< updates

  void reset();
  /// A window of the mains as it is now: amplitude > 0 (any unit), phase and reference frequency, 2^-32 turns (an
  /// update).
  void push(float amplitude, std::uint32_t phase, std::uint32_t step);
  /// The windows in between do not count.
  void skip() { filled_ = 0; }
  /// Square of the standard uncertainty of the phase by a tone that the estimate follows, turns^2.
  float variance() const { return variance_; }

 private:
  static constexpr unsigned slots = 32;
  static_assert(slots > lag);
  std::array<float, slots> amplitude_{};
  std::array<std::uint32_t, slots> phase_{};
  unsigned at_ = 0;
  int filled_ = 0;
  float count_ = 0;
  std::uint32_t step_ = 0;                       ///< reference: the first
  float usual_ = 0;                              ///< amplitude, about
  float mean_a_ = 0, mean_p_ = 0;                ///< relative; turns
  float a_a_ = 0, p_p_ = 0, d_d_ = 0, p_a_ = 0;  ///< mean products
  float variance_ = 0;
};

}  // namespace powbench::firmware
