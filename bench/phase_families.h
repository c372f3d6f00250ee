#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "bench/phase_scenarios.h"
#include "core/random.h"

/// Families of disturbed mains whose parameters are drawn by a seed: what a stated uncertainty is judged on.

namespace powbench::bench {

/// Which draws: those an estimator may be adjusted on, those it is judged on, and those on which the judgement itself
/// is checked. The seeds are disjoint.
enum class Draws : std::uint8_t { tuning, scoring, fresh };

inline constexpr double case_seconds = 3.0;    ///< length of one case
inline constexpr double case_settles = 0.5;    ///< s; nothing is judged before
inline constexpr double track_hertz = 1000.0;  ///< grid of the frequency

/// A tone beside the harmonics. On between `from` and `to` of each `period` (s; period 0 = always).
struct Tone {
  double hertz = 0, share = 0, turns = 0;
  double period = 0, from = 0, to = 0;
};

/// Amplitude and phase between two instants.
struct Event {
  double from = 0, to = 0;  ///< s
  double factor = 1;        ///< amplitude meanwhile
  double jump = 0;          ///< turns of the phase, meanwhile only
};

/// One damped oscillation: share exp(-t / decay) sin(2 pi hertz t) from `at` on.
struct Transient {
  double at = 0, share = 0, hertz = 0, decay = 0;
};

/// All of one case. Shares are of the nominal peak of the fundamental.
struct MainsCase {
  std::string_view family;
  std::uint64_t seed = 0;
  double start_turns = 0;
  double amplitude = 1;
  std::vector<double> track;                         ///< Hz at k / track_hertz, straight lines between
  std::array<std::complex<double>, 16> harmonics{};  ///< order k: Im(h_k exp(j k phase)); k = 0 and 1 unused
  double offset = 0;
  double noise = 0;       ///< rms, white up to 50 kHz ...
  double band_noise = 0;  ///< rms, white up to 5 kHz
  std::vector<Tone> tones;
  double flicker = 0, flicker_hertz = 0;  ///< amplitude factor 1 + flicker sin(...)
  bool flicker_square = false;
  double notch_depth = 0, notch_seconds = 0,
         notch_start = 45;                ///< six a cycle, towards zero; deg after each sixth
  double spike = 0, spikes_a_second = 0;  ///< single samples
  double half_wave = 0;                   ///< share of a half-wave rectified sine added ...
  double half_wave_from = 0;              ///< ... from here on, s
  std::vector<Event> events;
  std::vector<Transient> transients;
  double missing_from = -1, missing_to = -1;  ///< s: no positive half-waves in between
  double clip_low = -10, clip_high = 10;      ///< the input clips here
  std::vector<double>
      breaks;  ///< s: instants that nothing before them announces (jumps, sags, missing half-waves)
  std::vector<double> onsets;  ///< s: a movement of the frequency begins or ends with a corner
};

/// Undisturbed mains of one frequency, to be disturbed by hand.
MainsCase plain_case(double hertz, std::uint64_t seed);

std::span<const std::string_view> family_names();

/// One draw. Throws std::invalid_argument for a family that does not exist.
MainsCase draw_case(std::string_view family, Draws, int number);

/// The samples of a case one after the other, and the truth.
class CaseSource {
 public:
  explicit CaseSource(const MainsCase&);
  /// Next sample: 12 bits in the upper bits of the word, saturating.
  std::int16_t next();
  /// True phase of the fundamental, turns, not wrapped; 0 <= t <= case_seconds + 0.2.
  double phase(double t) const;
  double hertz(double t) const;
  /// Something that could not be foreseen happens in (from, to].
  bool breaks(double from, double to) const;
  /// A corner of the frequency lies in (from, to].
  bool onsets(double from, double to) const;

 private:
  double waveform(double t);

  const MainsCase* case_;
  std::vector<double> turns_;  ///< at the grid of the track
  Random random_;
  double held_noise_ = 0;
  std::int64_t index_ = 0;
};

}  // namespace powbench::bench
