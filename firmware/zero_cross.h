#pragma once

#include <cstdint>

/// Phase from zero crossings of the low-pass filtered waveform.

namespace powbench::firmware {

/// Two equal one-pole low-passes, then linear interpolation of the crossings. The middle of two neighbouring
/// crossings is a crest or a trough whatever the offset; the delay of the low-passes is taken off at the
/// measured frequency.
class ZeroCross {
 public:
  struct Config {
    float rate = 10000.0F;       ///< Hz
    float corner_hertz = 30.0F;  ///< of each low-pass
    float hysteresis =
        0.02F;  ///< unit of the input after filtering: a crossing counts after this much beyond the last one
    bool cancel_offset = true;  ///< middle of two crossings; false: the newest crossing alone
  };

  explicit ZeroCross(const Config& config);
  void reset();
  void push(float value);

  bool ready() const { return crossings_ >= 4; }  ///< enough crossings for a phase and a frequency
  float turns() const { return turns(hertz_); }   ///< [0, 1) at the last pushed sample
  /// The same with a frequency that is known better than that of the last cycle.
  float turns(float hertz) const;
  float hertz() const { return hertz_; }
  float since_crossing() const { return since_last_; }  ///< samples since the newest crossing

 private:
  void crossing(float age, bool rising);
  float delay_turns(float hertz) const;

  Config config_;
  float keep_;  ///< 1 - pole gain
  float first_ = 0;
  float second_ = 0;
  float swing_ = 0;         ///< largest |value| since the last crossing
  float since_last_ = 0;    ///< samples since the newest crossing
  float half_[2] = {0, 0};  ///< lengths of the last two half-cycles, samples
  float hertz_ = 0;
  bool last_rising_ = false;
  std::int32_t crossings_ = 0;  ///< saturates at 4
};

}  // namespace powbench::firmware
