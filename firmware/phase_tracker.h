#pragma once

#include <array>
#include <cstdint>

#include "firmware/beat_watch.h"
#include "firmware/cycle_compare.h"
#include "firmware/jump_guard.h"
#include "firmware/mains_ring.h"
#include "firmware/phase_bank.h"
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
///    the frequency, and that of the last cycle alone (window_phasor.h).
/// 3. Polynomials over memories from 10 ms to half a second predict the phase; their average, weighted by what each
///    has lately been wrong by, is the estimate, and its errors are the uncertainty (PhaseBank).
/// 4. The waveform is compared with that of a cycle ago (CycleCompare): a change is noticed within a few milliseconds.
///    While a window spans it the phase goes on as it was before, and what it would have been stands in the memory of
///    step 3. If the phase may have jumped, the estimate is invalid until 18 windows behind the change have been
///    compared with that: where they differ by a level, the whole memory is given that level; where they differ by a
///    slope, it starts again.
/// 5. A SOGI-PLL and the zero crossings must agree with the result before it is valid.
///
/// State is bounded (11 kB) and may live in static memory. push() costs a few operations, at each tenth
/// sample some hundred, and once a millisecond the estimate. PhaseFeed keeps all but the few operations out of
/// the interrupt of the samples.
class PhaseTracker {
 public:
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
  /// The newest point does not look like the mains of a cycle ago: no edge now. Renewed with each point, not only with
  /// the estimate.
  bool suspicious() const { return guard_.suspicious(); }
  /// Index of the newest sample: the first one pushed has index 0; -1 before it.
  std::int64_t sample() const { return sample_; }

  /// The next instant of a phase by the latest estimate.
  PhaseInstant next_instant(CentiDegrees target, std::int64_t earliest) const {
    return firmware::next_instant(estimate_, config_.sample_rate, target, earliest);
  }

 private:
  bool take(std::int32_t sum);
  void note_clipping(std::int32_t sum);
  float model_variance() const;
  void watch_beat(float amplitude, std::uint32_t step);
  void restart();
  void absent();
  void place_window();  ///< chooses middle_
  void notice_changes();
  void remember(const WindowPhasor& phasor, bool hidden);
  /// Phasors whose windows lie within the newest `clean` samples of the history.
  int entries_within(int clean) const;
  void learn(int clean, std::uint32_t step);
  void coast();
  void compare_windows(int clean);
  void begin_change(int clean, bool event);
  void restart_memory();
  void publish(const BankSay& say, std::uint32_t step, int now, int ahead);
  void extrapolate(const PhaseEstimate& from);
  std::uint16_t gate(const WindowPhasor& phasor, int clean) const;

  PhaseTrackerConfig config_;
  int decimation_;
  float rate_;       ///< of the history, Hz
  int update_step_;  ///< samples of the history between estimates, about a millisecond
  float lag_;        ///< s from the newest point of the history to the newest sample
  float scale_;      ///< sum of counts to units of nominal amplitude
  MainsRing ring_;
  CycleCompare compare_;
  JumpGuard guard_;
  SogiPll pll_;
  ZeroCross zero_cross_;
  PhaseBank bank_;
  BeatWatch beat_;
  int middle_ = 0;  ///< samples of the history from the middle of the window to the newest: whole updates
  int before_ = 0;  ///< middle_ of the newest phasor, 0 = none
  int entry_count_ = 0;                  ///< phasors since the memory started
  std::uint32_t newest_phase_ = 0;       ///< 2^-32 turns
  std::uint32_t newest_seen_ = 0;        ///< of the window; the same but behind a change
  std::array<PhaseEstimate, 2> kept_{};  ///< older estimates: what goes on after a change is from before it
  int since_kept_ = 0;
  int keep_hertz_ = 0;           ///< updates for which windows that span a change do not change the frequency
  int coast_ = 0;                ///< updates that the estimate may still go on without new phases
  bool changed_ = false;         ///< the waveform has changed, and the windows behind that are not enough yet
  bool event_ = false;           ///< ... and its phase may have jumped
  bool no_jump_ = false;         ///< ... but has not, though the change was sudden
  float jump_doubt_ = 0;         ///< turns^2: square of a jump that is not seen to be none
  bool doubtful_ = false;        ///< ... but that is not known yet
  int since_change_ = 0;         ///< updates, saturates
  float unexpected_ = 0;         ///< the newest window less what was predicted, turns
  float level_ = 0, slope_ = 0;  ///< sums of the windows behind a change less what was predicted, turns
  float square_ = 0;             ///< of their squares, turns^2
  std::int32_t sum_ = 0;
  int summed_ = 0;
  int since_update_ = 0;
  int clean_ = 0;   ///< samples of the history since the last change, saturates
  int spared_ = 0;  ///< ... since the last change that the memory did not outlive
  std::int32_t level_sum_ = 0;
  int level_run_ = 0;  ///< points equal to the one before
  float clipped_ = 0;  ///< share of the points at which the input clips
  bool gap_ = false;
  bool quiet_ = false;
  float cycle_ = 0;  ///< samples of the history in a cycle, now
  std::int64_t sample_ = -1;
  PhaseEstimate estimate_;
};

}  // namespace powbench::firmware
