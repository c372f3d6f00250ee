#pragma once

#include <array>
#include <cstdint>

/// Front end of the phase tracker: decimation to about 10 kS/s, repair of commutation notches, history of the
/// waveform.

namespace powbench::firmware {

/// Waveform in units of the nominal amplitude, newest sample last; bounded history.
///
/// Notch repair: a sample further than `notch_threshold` from the line through the last good samples opens a
/// notch. While it is open the line stands in for the samples. It closes at the second sample back within
/// half of its depth; the notch, with one sample on either side, is then replaced by the parabola through the
/// good samples around it. A step that lasts longer than `longest_notch` is no notch: the raw samples are put
/// back.
class MainsRing {
 public:
  static constexpr int capacity = 1024;                ///< samples; a power of two
  static constexpr float notch_threshold = 0.08F;      ///< of nominal amplitude
  static constexpr int longest_notch = 6;              ///< samples
  static constexpr int final_age = longest_notch + 2;  ///< samples this old and older do not change any more

  void reset();
  /// Adds one sample (units of nominal amplitude).
  void push(float raw);
  /// Number of samples pushed since reset.
  std::int64_t count() const { return count_; }
  /// Sample `age` before the newest (age 0). Range: 0 .. capacity - 1, and < count().
  float back(int age) const { return samples_[static_cast<std::uint32_t>(count_ - 1 - age) & mask]; }

 private:
  static constexpr std::uint32_t mask = capacity - 1;
  float& slot(int age) { return samples_[static_cast<std::uint32_t>(count_ - 1 - age) & mask]; }
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
};

}  // namespace powbench::firmware
