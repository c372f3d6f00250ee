#pragma once

#include <array>
#include <cstdint>

#include "firmware/cycle_compare.h"
#include "firmware/mains_ring.h"
#include "firmware/phase_estimate.h"
#include "firmware/sogi.h"
#include "firmware/window_phasor.h"
#include "firmware/zero_cross.h"

/// Phase of the mains, from its samples. Portable core: no heap, no exceptions, no libm transcendentals.

namespace powbench::firmware {

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
/// 3. The phases of the last 0.9 cycles (a mains that repeats itself), 18 ms at least, to 3.1 cycles (a noisy one) are fitted
///    with a parabola in time, whose bend is held back by the noise, and the parabola is evaluated at the
///    newest sample.
/// 4. The waveform is compared with that of a cycle ago: an event is noticed within a few milliseconds,
///    invalidates the estimate, and the memory of step 3 starts again behind it.
/// 5. A SOGI-PLL and the zero crossings must agree with the result before it is valid.
/// Nothing in steps 1 to 3 is recursive, so whatever has left the memory is forgotten.
///
/// State is bounded (5.4 kB) and may live in static memory. push() costs a few operations, at each tenth
/// sample some hundred, and once a millisecond the estimate. PhaseFeed keeps all but the few operations out of
/// the interrupt of the samples.
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
  /// The same for `decimation()` samples at once, given by their sum. Not to be mixed with single samples.
  bool push_sum(std::int32_t counts) {
    sample_ += decimation_;
    return take(counts);
  }
  /// Samples in a point of the history.
  int decimation() const { return decimation_; }
  void update();
  /// `lost` samples are missing before the next one: the sample index passes over them and the memory starts
  /// again.
  void mark_gap(std::int64_t lost = 0);

  const PhaseEstimate& estimate() const { return estimate_; }
  /// Index of the newest sample: the first one pushed has index 0; -1 before it.
  std::int64_t sample() const { return sample_; }

  /// The next instant of a phase by the latest estimate.
  PhaseInstant next_instant(CentiDegrees target, std::int64_t earliest) const {
    return firmware::next_instant(estimate_, config_.sample_rate, target, earliest);
  }

 private:
  struct Entry {
    float turns;  ///< phase at the middle of the window
    float age;    ///< samples of the history from there to the update that made it
    float cycle;  ///< samples of the history in the cycle of the window
  };

  bool take(std::int32_t sum);
  void restart();
  void absent();
  int clean_entries(int most) const;  ///< phasors whose windows lie behind the last event, `most` at most
  int wanted_entries() const;         ///< phasors to fit
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
