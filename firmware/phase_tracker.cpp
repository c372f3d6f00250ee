#include "firmware/phase_tracker.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {

constexpr float history_rate = 10000.0F;      ///< Hz, at most
constexpr float lowest_valid_hertz = 44.85F;  ///< 45 .. 65 Hz, with what the estimate may be off
constexpr float highest_valid_hertz = 65.15F;
constexpr float absent_amplitude = 0.2F;  ///< of nominal: below it there is no mains
constexpr float lowest_amplitude = 0.7F;  ///< of nominal
constexpr float highest_amplitude = 1.2F;
constexpr float largest_residual = 0.15F;  ///< rms, of the fundamental's
constexpr float cross_check_limit = 3.0F / 360;
constexpr float third_opinion_limit = 5.0F / 360;
constexpr float repair_doubt = 0.7F / 360;  ///< turns for a mean repair of the nominal amplitude
constexpr float clip_doubt = 0.6F / 360;    ///< turns for an input that always clips
constexpr float least_clip_level = 0.5F;    ///< of nominal
constexpr float clip_gain = 0.005F;         ///< a point of the history
constexpr int fewest_level = 4;             ///< equal points after the first: 9 deg of 50 Hz
constexpr int fewest_entries = 18;          ///< phasors a valid estimate rests on
constexpr int longest_memory = 1 << 14;     ///< samples of the history
constexpr int longest_coast = 96;           ///< updates
constexpr int keep_interval = 32;           ///< updates
constexpr float wrong_cycle = 0.004F;       ///< the window of one cycle is biased beyond it
constexpr float stale_window = 0.03F;       ///< a window this much off in length is not used

float magnitude(float x) {
  return x < 0.0F ? -x : x;
}
std::uint16_t bit(PhaseFault fault, bool set) {
  return set ? static_cast<std::uint16_t>(fault) : std::uint16_t{0};
}

}  // namespace

PhaseTracker::PhaseTracker(const PhaseTrackerConfig& config)
    : config_(config),
      decimation_(static_cast<int>(config.sample_rate / history_rate + 0.999F)),
      rate_(config.sample_rate / static_cast<float>(decimation_)),
      update_step_(static_cast<int>(rate_ * 0.001F + 0.5F)),
      lag_(0.5F * static_cast<float>(decimation_ - 1) / config.sample_rate),
      scale_(1.0F / (config.nominal_amplitude * static_cast<float>(decimation_))),
      pll_({.rate = rate_, .nominal_hertz = config.nominal_hertz, .loop_hertz = 16.0F}),
      zero_cross_({.rate = rate_}) {
  reset();
}

void PhaseTracker::reset() {
  sample_ = -1;
  restart();
  pll_.reset();
  zero_cross_.reset();
  gap_ = false;
  coast_ = 0;
  cycle_ = rate_ / config_.nominal_hertz;
  estimate_ = no_estimate(config_.nominal_hertz);
}

void PhaseTracker::restart() {
  ring_.reset();
  compare_.reset();
  entry_count_ = before_ = 0;
  bank_.reset();
  sum_ = 0;
  summed_ = since_update_ = clean_ = 0;
  quiet_ = false;
  level_run_ = 0;
  level_sum_ = 0;
  clipped_ = 0.0F;
}

void PhaseTracker::mark_gap(std::int64_t lost) {
  sample_ += lost;
  restart();
  gap_ = true;
  estimate_.faults |= static_cast<std::uint16_t>(PhaseFault::gap);
}

bool PhaseTracker::push_sample(std::int16_t mains_counts) {
  ++sample_;
  sum_ += mains_counts;
  if (++summed_ < decimation_) return false;
  const std::int32_t sum = sum_;
  sum_ = 0;
  summed_ = 0;
  return take(sum);
}

/// Neighbouring points at the crest are equal only where the input clips: noise and the wave itself move them.
void PhaseTracker::note_clipping(std::int32_t sum) {
  const float level = magnitude(static_cast<float>(sum) * scale_);
  level_run_ = sum == level_sum_ && level > least_clip_level ? level_run_ + 1 : 0;
  level_sum_ = sum;
  clipped_ += ((level_run_ >= fewest_level ? 1.0F : 0.0F) - clipped_) * clip_gain;
}

/// One more point of the history.
bool PhaseTracker::take(std::int32_t sum) {
  note_clipping(sum);
  ring_.push(static_cast<float>(sum) * scale_);
  if (ring_.count() > MainsRing::final_age) {
    pll_.push(ring_.back(MainsRing::final_age));
    zero_cross_.push(ring_.back(MainsRing::final_age));
  }
  // The cycle between now and one cycle ago has the frequency of half a cycle ago.
  const float cycle = cycle_ * (1.0F + 0.5F * estimate_.frequency_rate * cycle_ * cycle_ / (rate_ * rate_));
  if (ring_.count() > static_cast<std::int32_t>(cycle) + MainsRing::final_age + 2)
    compare_.push(ring_, cycle);
  if (clean_ < longest_memory) ++clean_;
  if (++since_update_ < update_step_) return false;
  since_update_ = 0;
  return true;
}

int PhaseTracker::clean_entries() const {
  const int reach = middle_ + static_cast<int>(cycle_) + 1;
  const int clean = clean_ < reach ? 0 : (clean_ - reach) / update_step_ + 1;
  return clean < entry_count_ ? clean : entry_count_;
}

/// The middle stays whole updates before the newest sample, so that phases lie on an even grid.
void PhaseTracker::place_window() {
  const int least = static_cast<int>(cycle_) + 1;
  if (entry_count_ == 0) middle_ = 0;
  if (middle_ < least) middle_ = (least + update_step_ - 1) / update_step_ * update_step_;
  if (middle_ > least + update_step_ + update_step_ / 4) middle_ -= update_step_;
}

void PhaseTracker::remember(const WindowPhasor& phasor) {
  const float hertz = rate_ / cycle_;
  const auto phase = static_cast<std::uint32_t>(phasor.turns * 4294967296.0F);
  const int moved = before_ == 0 ? 1 : 1 - (middle_ - before_) / update_step_;  // places of the grid
  before_ = middle_;
  if (moved >= 2) bank_.push(newest_phase_ + (phase - newest_phase_) / 2), ++entry_count_;
  if (moved >= 1) bank_.push(phase), ++entry_count_;
  newest_phase_ = phase;
  if (entry_count_ > longest_memory) entry_count_ = longest_memory;
  const auto after = static_cast<int>(0.5F * cycle_ / static_cast<float>(update_step_) + 0.5F);
  const float shift = (static_cast<float>(after * update_step_) - 0.5F * cycle_) * hertz / rate_;
  bank_.push_late(static_cast<std::uint32_t>(wrap_turns(phasor.late_turns + shift) * 4294967296.0F), after);
}

/// The estimate as it follows from an earlier one; its rate counts for `rate_horizon`.
void PhaseTracker::extrapolate(const PhaseEstimate& from) {
  const float time =
      static_cast<float>(static_cast<std::int32_t>(sample_ - from.sample)) / config_.sample_rate;
  const float curved = time < rate_horizon ? time : rate_horizon;
  const float rate = from.frequency_rate;
  estimate_.phase_turns =
      wrap_turns(from.phase_turns + time * from.frequency + rate * curved * (time - 0.5F * curved));
  estimate_.frequency = clamp_hertz(from.frequency + rate * curved);
  estimate_.frequency_rate = 0.0F;
  estimate_.sample = sample_;
}

void PhaseTracker::update() {
  extrapolate(estimate_);
  quiet_ = compare_.judge();
  if (compare_.changing() && clean_ > static_cast<int>(cycle_) + MainsRing::final_age)
    clean_ = static_cast<int>(cycle_) + MainsRing::final_age;
  // Without a history to go by, the zero crossings say where to look.
  const float crossing_hertz = zero_cross_.hertz();
  if (entry_count_ == 0 && zero_cross_.ready() && crossing_hertz > lowest_hertz &&
      crossing_hertz < highest_hertz) {
    cycle_ = rate_ / crossing_hertz;
  }
  place_window();
  if (ring_.count() < middle_ + static_cast<std::int32_t>(cycle_) + 2) {
    estimate_.faults = static_cast<std::uint16_t>(PhaseFault::warming_up) | bit(PhaseFault::gap, gap_);
    return;
  }
  const WindowPhasor phasor = window_phasor(ring_, cycle_, middle_);
  estimate_.amplitude = phasor.amplitude * config_.nominal_amplitude;
  if (phasor.amplitude < absent_amplitude) return absent();
  remember(phasor);
  const int clean = clean_entries();
  const float updates = static_cast<float>(update_step_) / rate_;
  const auto step = static_cast<std::uint32_t>(updates * rate_ / cycle_ * 4294967296.0F);
  const int now = middle_ / update_step_;
  const int ahead = now + static_cast<int>(0.020F / updates + 0.5F);
  if (clean < 2) bank_.event();
  const float window_cycle = cycle_;
  if (entry_count_ >= fewest_entries) {
    const BankSay say = bank_.say(clean, step, now, ahead);
    const PhaseEstimate before = estimate_;
    publish(say, step, now, ahead);
    const int newer = static_cast<int>(cycle_) + MainsRing::final_age;
    if (say.broken && clean_ > newer) clean_ = newer;
    if (clean >= fewest_entries) {
      if (++since_kept_ >= keep_interval) {
        since_kept_ = 0;
        kept_[1] = kept_[0];
        kept_[0] = estimate_;
        if (coast_ < longest_coast) coast_ += keep_interval;
      }
    } else if (coast_ > 0) {
      // after an event the phase goes on as it was until there is enough behind the event to go by
      if (since_kept_ >= 0)
        extrapolate(kept_[1]);
      else
        estimate_ = before;
      since_kept_ = -1;
      --coast_;
    }
  }
  if (magnitude(cycle_ - window_cycle) > wrong_cycle * cycle_) bank_.forget_late();
  if (magnitude(cycle_ - window_cycle) > stale_window * cycle_) entry_count_ = 0, before_ = 0;
  estimate_.faults = gate(phasor, clean);
  if (estimate_.valid()) gap_ = false;
}

void PhaseTracker::absent() {
  // The frequency stays, so that a mains that comes back is found at once.
  entry_count_ = before_ = 0;
  bank_.event();
  estimate_.frequency_rate = 0.0F;
  estimate_.faults = static_cast<std::uint16_t>(PhaseFault::warming_up) |
                     static_cast<std::uint16_t>(PhaseFault::amplitude) | bit(PhaseFault::gap, gap_) |
                     bit(PhaseFault::disturbed, !quiet_);
  zero_cross_.reset();
}

void PhaseTracker::publish(const BankSay& say, std::uint32_t step, int now, int ahead) {
  const float update = static_cast<float>(update_step_) / rate_;
  const float span = static_cast<float>(ahead - now) * update;
  const float rate = say.rate / (update * update);
  const float reference = static_cast<float>(step) * 0x1p-32F / update;
  const float hertz = clamp_hertz(reference + (say.ahead - say.now) / span - 0.5F * rate * span);
  const std::uint32_t word = newest_phase_ + step * static_cast<std::uint32_t>(now);
  estimate_.phase_turns = wrap_turns(static_cast<float>(word) * 0x1p-32F + say.now + hertz * lag_);
  estimate_.frequency = hertz;
  estimate_.frequency_rate = rate;
  const float model = model_variance();
  estimate_.variance = say.variance_now + model;
  estimate_.variance_ahead = say.variance_ahead + model;
  cycle_ = rate_ / hertz;
}

/// A bias that does not change is not seen in errors of predictions. It comes from what has been put in the place of
/// samples and from an input that clips; turns^2.
float PhaseTracker::model_variance() const {
  const float repaired = repair_doubt * ring_.altered();
  const float clipped = clip_doubt * clipped_;
  return repaired * repaired + clipped * clipped;
}

std::uint16_t PhaseTracker::gate(const WindowPhasor& phasor, int clean) const {
  const float hertz = estimate_.frequency;
  // The other two stand where the history has become final.
  const float final_lag = lag_ + static_cast<float>(MainsRing::final_age) / rate_;
  const float then = wrap_turns(estimate_.phase_turns - hertz * final_lag);
  const bool enough = clean >= fewest_entries;
  const bool zero_cross_agrees = zero_cross_.ready() && zero_cross_.since_crossing() < cycle_ &&
                                 magnitude(wrap_half(zero_cross_.turns(hertz) - then)) <= third_opinion_limit;
  std::uint16_t faults = 0;
  faults |= bit(PhaseFault::warming_up, !enough);
  faults |= bit(PhaseFault::amplitude,
                !(phasor.amplitude >= lowest_amplitude && phasor.amplitude <= highest_amplitude));
  faults |= bit(PhaseFault::frequency, !(hertz >= lowest_valid_hertz && hertz <= highest_valid_hertz));
  faults |= bit(PhaseFault::residual, !(phasor.residual <= largest_residual));
  faults |= bit(PhaseFault::cross_check, !(magnitude(wrap_half(pll_.turns() - then)) <= cross_check_limit));
  faults |= bit(PhaseFault::third_opinion, !zero_cross_agrees);
  faults |= bit(PhaseFault::gap, gap_ && !enough);
  faults |= bit(PhaseFault::disturbed, !quiet_);
  return faults;
}

}  // namespace powbench::firmware
