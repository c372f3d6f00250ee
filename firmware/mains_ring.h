#pragma once

#include <array>
#include <cstdint>

/// Front end of the phase tracker: decimation to about 10 kS/s, repair of commutation notches, history of the
/// waveform.

namespace powbench::firmware {

/// Waveform in units of the nominal amplitude, newest sample last; bounded history.
///
/// Notch repair: a sample further than `notch_threshold`, and than four times the median of such distances, from the
/// line through the last good samples opens a notch. (Ripple of a converter is no notch: it is there all the time.)
/// While it is open the line stands in for the samples. It closes at the second sample back within half of its depth;
/// while a notch is remembered (11 ms) a distance of 0.03 opens the next one, for notches come six a cycle and those
/// near a zero crossing are shallow. The notch, with one sample on either side, is then replaced by the parabola
/// through the good samples around it. A step that lasts longer than `longest_notch` is no notch: the raw samples are
/// put back.
class MainsRing {
 public:
  static constexpr int capacity = 512;  ///< samples; a power of two: two cycles of 43 Hz at 10 kS/s
  static constexpr float notch_threshold = 0.08F;      ///< of nominal amplitude
  static constexpr int usual_notch = 6;                ///< samples
  static constexpr int longest_notch = 8;              ///< samples
  static constexpr int final_age = longest_notch + 2;  ///< samples this old and older do not change any more

  void reset();
  /// Adds one sample (units of nominal amplitude).
  void push(float raw);
  /// Number of samples pushed since reset.
  std::int64_t count() const { return count_; }
  /// Mean of |sample - what stands in for it| over about a cycle, units of nominal amplitude.
  float altered() const { return altered_; }
  /// Depth below which notches among others are not seen for the roughness of the wave, beyond what is usual; units of
  /// nominal amplitude. 0 without notches.
  float hidden() const;
  /// The newest sample as it came.
  float newest() const { return open_ > 0 ? raw_[static_cast<std::uint32_t>(open_ - 1)] : back(0); }
  /// The newest samples may be those of a notch, for one has been there lately.
  bool notched() const { return recent_ > 0; }
  bool notch_open() const { return open_ > 0; }
  /// Sample `age` before the newest (age 0). Range: 0 .. capacity - 1, and < count().
  float back(int age) const { return samples_[static_cast<std::uint32_t>(count_ - 1 - age) & mask]; }

 private:
  static constexpr int fewest_repeated = 12;
  static constexpr std::uint32_t mask = capacity - 1;
  float& slot(int age) { return samples_[static_cast<std::uint32_t>(count_ - 1 - age) & mask]; }
  bool repeated() const { return recent_ > 0 && seen_ >= fewest_repeated; }
  float threshold() const;  ///< distance from the line at which a notch opens
  void note_notch();
  void close_notch();
  void give_up();

  std::array<float, capacity> samples_{};
  std::array<float, longest_notch + 2> raw_{};  ///< raw samples of the open notch
  std::int64_t count_ = 0;
  int open_ = 0;      ///< samples in the open notch, 0 = none
  int returned_ = 0;  ///< consecutive samples of the open notch that are back on the line
  int quiet_ = 0;     ///< good samples still to see before a notch may open
  float depth_ = 0;   ///< largest distance from the line in the open notch
  float anchor_ = 0;  ///< last good sample before the notch
  float slope_ = 0;   ///< per sample
  int recent_ = 0;    ///< good samples for which the last notch is still remembered
  int seen_ = 0;      ///< notches, each within the memory of the one before
  float usual_ = 0;   ///< median distance of a sample from the line
  float altered_ = 0;
};

}  // namespace powbench::firmware
