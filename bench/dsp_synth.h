#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "core/record.h"

/// Synthetic force records with exact ground truth: contact pulses, a settled contact with 100 Hz pulsation,
/// core ringing, hum, charge-amplifier droop, noise and clipping. Reproducible bit for bit from the seed.

namespace powbench::bench {

enum class ForceCase : std::uint8_t {
  clean,
  hum,
  ring_in_band,
  ring_out_of_band,
  ring_overlap,
  ring_and_hum,
  short_pulses,
  droop,
  clip
};
enum class PulseForm : std::uint8_t { half_sine, hertz, asymmetric };

std::string_view name(ForceCase);
std::string_view name(PulseForm);

struct SynthSettings {
  ForceCase force_case = ForceCase::clean;
  PulseForm form = PulseForm::half_sine;
  double snr_db = 40;           ///< 20 log10(10 N / sigma of the white noise per sample)
  double rate = 1e6;            ///< Hz
  double mains_hertz = 50;      ///< Hz
  bool with_core_seat = false;  ///< adds a laser channel that shows the core seat (start of the ringing)
};

struct TrueContact {
  double touch = 0;
  double release = std::numeric_limits<double>::infinity();  ///< s; infinity = stays closed
  double peak = 0;                                           ///< N
};

struct SynthRecord {
  Record record;
  std::vector<TrueContact> contacts;
  double ring_onset = std::numeric_limits<double>::quiet_NaN();  ///< s
  double noise = 0;                                              ///< N, one sample
};

/// 40 ms before and 35 ms after switch-on; 2 or 3 bounces of about 10, 5, 2.5 N, then settled at 3 .. 6 N.
SynthRecord synthesise(const SynthSettings&, std::uint64_t seed);

/// A whole eight-channel record (140 ms at `rate`), every channel busy: for cost and for the closing angle.
struct FullTruth {
  double closing_angle = 0;  ///< rad
  double core_seat = 0;      ///< s
  double impact_velocity = 0;
};
Record synthesise_full(double rate, double mains_hertz, double closing_angle, std::uint64_t seed,
                       FullTruth* truth = nullptr);

/// xoshiro256** and sums of uniforms: plain arithmetic, the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed);
  double uniform();                         ///< [0, 1)
  double uniform(double low, double high);  ///< [low, high)
  double normal();                          ///< sum of 12 uniforms - 6: mean 0, variance 1, |x| <= 6
 private:
  std::uint64_t next();
  std::uint64_t s_[4];
};

}  // namespace powbench::bench
