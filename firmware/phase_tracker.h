#pragma once

#include <array>
#include <cstdint>

#include "core/phase.h"
#include "firmware/cycle_compare.h"
#include "firmware/mains_ring.h"
#include "firmware/sogi.h"
#include "firmware/window_phasor.h"
#include "firmware/zero_cross.h"

/// Phase of the mains, from its samples. Portable core: no heap, no exceptions, no libm transcendentals.

namespace powbench::firmware {

/// Why an estimate must not be fired on. One bit each.
enum class PhaseFault : std::uint16_t {
  none = 0,
  warming_up = 1U << 0,     ///< history shorter than the estimator's memory
  amplitude = 1U << 1,      ///< outside 0.7 .. 1.2 of nominal
  frequency = 1U << 2,      ///< outside 45 .. 65 Hz
  residual = 1U << 3,       ///< signal minus fitted fundamental above 15 % rms
  cross_check = 1U << 4,    ///< second estimator differs by more than 3 deg
  third_opinion = 1U << 5,  ///< zero crossing differs by more than 5 deg
  gap = 1U << 6,            ///< samples were lost inside the memory
  disturbed = 1U << 7,      ///< the waveform is not the one of a cycle ago
};

/// The mains fundamental v(n) = amplitude sin(phase + 2 pi frequency (n - sample) / rate), referred to sample
/// index `sample`.
struct PhaseEstimate {
  std::int64_t sample = 0;   ///< sample index the phase refers to
  float phase_turns = 0;     ///< [0, 1): 0 = rising zero crossing
  float frequency = 0;       ///< Hz
  float frequency_rate = 0;  ///< Hz/s
  float amplitude = 0;       ///< counts, peak
  std::uint16_t faults = static_cast<std::uint16_t>(PhaseFault::warming_up);

  bool valid() const { return faults == 0; }
};

struct PhaseTrackerConfig {
  float sample_rate = 100000.0F;       ///< Hz; >= 20000
  float nominal_amplitude = 20000.0F;  ///< counts, peak of the nominal mains; > 0
  float nominal_hertz = 50.0F;         ///< Hz, 45 .. 65: where the search starts
};

/// Phase, frequency and rate of change of frequency of the mains fundamental.
///
/// 1. Samples are summed to about 10 kS/s. The middle of a sum lies (decimation - 1)/2 samples before its
///    last; its droop at the mains frequency, (pi f / rate)^2 / 6 < 1e-4, is left in the amplitude.
///    Commutation notches are repaired (MainsRing).
/// 2. Every millisecond the phasor of the last two cycles is taken with a Hann window whose length follows
///    the frequency.
/// 3. The phases of the last 1.2 cycles (a mains that repeats itself) to 3.1 cycles (a noisy one) are fitted
///    with a parabola in time, whose bend is held back by the noise, and the parabola is evaluated at the
///    newest sample.
/// 4. The waveform is compared with that of a cycle ago: an event is noticed within a few milliseconds,
///    invalidates the estimate, and the memory of step 3 starts again behind it.
/// 5. A SOGI-PLL and the zero crossings must agree with the result before it is valid.
/// Nothing in steps 1 to 3 is recursive, so whatever has left the memory is forgotten.
///
/// State is bounded (5.4 kB) and may live in static memory. push() costs a few operations, at each tenth
/// sample some hundred, and once a millisecond the estimate. A target that cannot afford that in its
/// interrupt calls push_sample() there and update() outside of it: update() reads at most 47 ms of the 102 ms
/// of history.
class PhaseTracker {
 public:
  static constexpr int max_entries = 80;  ///< phasors in the memory, one a millisecond

  explicit PhaseTracker(const PhaseTrackerConfig& config);

  void reset();
  /// One mains sample; renews the estimate when it is due.
  void push(std::int16_t mains_counts) {
    if (push_sample(mains_counts)) update();
  }
  /// One mains sample; true once a millisecond, when update() is due.
  bool push_sample(std::int16_t mains_counts);
  void update();
  /// `lost` samples are missing before the next one: the sample index passes over them and the memory starts
  /// again.
  void mark_gap(std::int64_t lost = 0);

  const PhaseEstimate& estimate() const { return estimate_; }
  /// Index of the newest sample: the first one pushed has index 0; -1 before it.
  std::int64_t sample() const { return sample_; }

  /// An instant of the sample clock: index and part of a sample, [0, 1).
  struct Instant {
    std::int64_t sample;
    float fraction;
  };
  /// The first instant at or after sample `earliest` at which the fundamental has phase `target` (0 ..
  /// 35999), by the latest estimate. The frequency rate counts for `rate_horizon` seconds from the estimate;
  /// then the frequency stays. Meaningful only while the estimate is valid; never before `earliest` in any
  /// case.
  Instant next_instant(CentiDegrees target, std::int64_t earliest) const;
  static constexpr float rate_horizon = 0.1F;

 private:
  struct Entry {
    float turns;  ///< phase at the middle of the window
    float age;    ///< samples of the history from there to the update that made it
    float cycle;  ///< samples of the history in the cycle of the window
  };

  void restart();
  void absent();
  int clean_entries() const;   ///< phasors whose windows lie behind the last event
  int wanted_entries() const;  ///< phasors to fit
  void fit(int entries, const Entry& newest);
  std::uint16_t gate(const WindowPhasor& phasor, int clean) const;
  const Entry& entry(int updates_ago) const;

  PhaseTrackerConfig config_;
  int decimation_;
  float rate_;       ///< of the history, Hz
  int update_step_;  ///< samples of the history between estimates, about a millisecond
  float lag_;        ///< s from the newest point of the history to the newest sample
  float scale_;      ///< sum of counts to units of nominal amplitude
  MainsRing ring_;
  CycleCompare compare_;
  SogiPll pll_;
  ZeroCross zero_cross_;
  std::array<Entry, max_entries> entries_{};
  int entry_count_ = 0;
  int newest_entry_ = 0;
  std::int32_t sum_ = 0;
  int summed_ = 0;
  int since_update_ = 0;
  int clean_ = 0;  ///< samples of the history since the last event, saturates
  bool gap_ = false;
  bool quiet_ = false;
  float noise_ = 0;    ///< of nominal amplitude, smoothed
  float cycle_ = 0;    ///< samples of the history in a cycle, now
  float fit_rms_ = 0;  ///< turns
  std::int64_t sample_ = -1;
  PhaseEstimate estimate_;
};

}  // namespace powbench::firmware
