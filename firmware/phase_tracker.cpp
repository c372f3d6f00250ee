#include "firmware/phase_tracker.h"

#include "firmware/math.h"

namespace powbench::firmware {

namespace {

constexpr float history_rate = 10000.0F;      ///< Hz, at most
constexpr float lowest_valid_hertz = 44.85F;  ///< 45 .. 65 Hz, with what the estimate may be off
constexpr float highest_valid_hertz = 65.15F;
constexpr float absent_amplitude = 0.08F,
                returned_amplitude = 0.2F;  ///< of nominal: below it there is no mains
constexpr float lowest_amplitude = 0.7F;    ///< of nominal
constexpr float highest_amplitude = 1.2F;
constexpr float largest_residual = 0.15F;  ///< rms, of the fundamental's
constexpr float cross_check_limit = 3.0F / 360;
constexpr float third_opinion_limit = 5.0F / 360;
constexpr float repair_doubt = 0.7F / 360;  ///< turns for a mean repair of the nominal amplitude
constexpr float hidden_doubt =
    1.8F / 360;  ///< turns for notches of the nominal amplitude that are not repaired
constexpr float clip_doubt = 0.5F / 360;  ///< turns for an input that always clips
constexpr float least_clip_level = 0.5F;  ///< of nominal
constexpr float clip_gain = 0.005F;       ///< a point of the history
constexpr int fewest_level = 4;           ///< equal points after the first: 9 deg of 50 Hz
constexpr int fewest_entries = 18;        ///< phasors a valid estimate rests on
constexpr int longest_memory = 1 << 14;   ///< samples of the history
constexpr int longest_coast = 96;         ///< updates
constexpr int longest_kept = 60;          ///< updates
constexpr int keep_interval = 12;         ///< updates
constexpr int longest_change = 1 << 10;   ///< updates
/// Updates since a change that moved no phase: sooner it cannot be told, and later it should be over.
constexpr int changed_least = 8, changed_most = 50;
constexpr int notice_delay = 4;  ///< updates
constexpr float leap = 9.0F;     ///< squared: three times the limit
constexpr float window_variance =
    0.1307F;                           ///< cycles^2: of a Hann window of two cycles, 4 (1/12 - 1/(2 pi^2))
constexpr float wrong_cycle = 0.004F;  ///< the window of one cycle is biased beyond it
constexpr float stale_window = 0.03F;  ///< a window this much off in length is not used

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
  cycle_ = rate_ / config_.nominal_hertz;
  estimate_ = no_estimate(config_.nominal_hertz);
}

void PhaseTracker::restart() {
  ring_.reset();
  compare_.reset();
  guard_.reset();
  entry_count_ = before_ = 0;
  bank_.reset();
  beat_.reset();
  sum_ = 0;
  summed_ = since_update_ = clean_ = spared_ = 0;
  coast_ = since_kept_ = keep_hertz_ = 0;
  changed_ = event_ = false;
  since_change_ = longest_change;
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
  if (ring_.count() > static_cast<std::int32_t>(cycle) + MainsRing::final_age + 2) {
    compare_.push(ring_, cycle);
    guard_.push(ring_, cycle);
  }
  if (clean_ < longest_memory) ++clean_;
  if (spared_ < longest_memory) ++spared_;
  if (++since_update_ < update_step_) return false;
  since_update_ = 0;
  return true;
}

int PhaseTracker::entries_within(int clean) const {
  const int reach = middle_ + static_cast<int>(cycle_) + 1;
  const int entries = clean < reach ? 0 : (clean - reach) / update_step_ + 1;
  return entries < entry_count_ ? entries : entry_count_;
}

void PhaseTracker::notice_changes() {
  const float step = static_cast<float>(update_step_);
  const float age = lag_ + (static_cast<float>(MainsRing::final_age) + 0.5F * step) / rate_;
  quiet_ = compare_.judge(wrap_turns(estimate_.phase_turns - estimate_.frequency * age), cycle_ / step);
  if (since_change_ < longest_change) ++since_change_;
  const int newer = static_cast<int>(cycle_) + MainsRing::final_age;
  if (compare_.changing() && clean_ > newer) begin_change(newer, false);
  // a change is noticed some milliseconds late: then a cycle of it is not longer than this
  const int cycle = static_cast<int>(cycle_ / step) - notice_delay;
  if (changed_ &&
      ((compare_.sudden() && !no_jump_) || (compare_.settled() > 1.0F && since_change_ == cycle) ||
       (compare_.evidence() > leap && since_change_ >= notice_delay)))
    event_ = true;
  if (!changed_ || event_) jump_doubt_ = 0.0F;
  if (changed_ && !event_ && since_change_ <= cycle) jump_doubt_ = compare_.doubt();
  if (event_ && since_change_ == cycle + notice_delay && compare_.settled() < 1.0F) {
    event_ = false, no_jump_ = true;  // a whole cycle shows another amplitude
    jump_doubt_ = compare_.doubt();
  }
  doubtful_ = changed_ && !event_ &&
              (since_change_ < changed_least || (compare_.evidence() > 1.0F && since_change_ < cycle));
  // nothing to go on by, or it leads astray
  if (changed_ && (coast_ <= 0 || (event_ && since_change_ == cycle && compare_.slips()) ||
                   (event_ && since_change_ > 2 * cycle + changed_least && compare_.evidence() > leap))) {
    bank_.resume(0.0F, 1.0F, since_change_, 0.0F);
    if (event_) keep_hertz_ = 0;
    restart_memory();
  }
}

/// Only the newest `clean` samples are of the mains as it is now.
void PhaseTracker::begin_change(int clean, bool event) {
  clean_ = clean;
  level_ = slope_ = square_ = 0.0F;
  if (entries_within(spared_) < fewest_entries) return restart_memory();
  if (!changed_) since_change_ = 0;
  no_jump_ = false;
  changed_ = true;
  event_ = event_ || event;
}

/// What was before the last change does not count any more.
void PhaseTracker::restart_memory() {
  changed_ = event_ = false;
  spared_ = clean_;
  since_change_ = longest_change;
}

/// The middle stays whole updates before the newest sample, so that phases lie on an even grid.
void PhaseTracker::place_window() {
  const int least = static_cast<int>(cycle_) + 1;
  if (entry_count_ == 0) middle_ = 0;
  if (middle_ < least) middle_ = (least + update_step_ - 1) / update_step_ * update_step_;
  if (middle_ > least + update_step_ + update_step_ / 4) middle_ -= update_step_;
}

/// `hidden`: the window spans a change, and what is predicted stands in its place.
void PhaseTracker::remember(const WindowPhasor& phasor, bool hidden) {
  const float hertz = rate_ / cycle_;
  const auto seen = static_cast<std::uint32_t>(phasor.turns * 4294967296.0F);
  const float age = lag_ + static_cast<float>(middle_) / rate_;
  const float then =
      estimate_.phase_turns - age * (estimate_.frequency - 0.5F * estimate_.frequency_rate * age);
  const auto expected = static_cast<std::uint32_t>(wrap_turns(then) * 4294967296.0F);
  const std::uint32_t phase = hidden ? expected : seen;
  unexpected_ = static_cast<float>(static_cast<std::int32_t>(seen - expected)) * 0x1p-32F;
  const int moved = before_ == 0 ? 1 : 1 - (middle_ - before_) / update_step_;  // places of the grid
  before_ = middle_;
  for (int i = moved < 2 ? moved : 2; i > 0; --i) {
    const auto half = static_cast<std::uint32_t>(i - 1);  // a place left out gets the middle
    const std::uint32_t then_seen = seen - half * ((seen - newest_seen_) / 2);
    if (hidden)
      bank_.push_expected(expected - half * ((expected - newest_phase_) / 2), then_seen);
    else
      bank_.push(then_seen);
    ++entry_count_;
  }
  newest_seen_ = seen;
  newest_phase_ = phase;
  if (entry_count_ > longest_memory) entry_count_ = longest_memory;
  const auto after = static_cast<int>(0.5F * cycle_ / static_cast<float>(update_step_) + 0.5F);
  const float shift = (static_cast<float>(after * update_step_) - 0.5F * cycle_) * hertz / rate_;
  if (hidden)
    return bank_.push_late(expected + static_cast<std::uint32_t>(static_cast<float>(after * update_step_) *
                                                                 hertz / rate_ * 4294967296.0F),
                           after);
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
  estimate_.frequency_rate = time < rate_horizon ? rate : 0.0F;
  estimate_.sample = sample_;
}

/// After a change the phase goes on as it was before; its uncertainty grows with the time.
void PhaseTracker::coast() {
  const PhaseEstimate& from = kept_[1];
  extrapolate(from);
  if (changed_) cycle_ = rate_ / estimate_.frequency;
  const float time =
      static_cast<float>(static_cast<std::int32_t>(sample_ - from.sample)) / config_.sample_rate;
  const float now = from.deviation(time);
  const float ahead = from.deviation(time + PhaseEstimate::ahead_seconds);
  estimate_.variance = now * now + jump_doubt_;
  estimate_.variance_ahead = ahead * ahead + jump_doubt_;
  --coast_;
}

/// Windows behind a change against what was predicted before it.
void PhaseTracker::compare_windows(int clean) {
  if (clean < 1) return;
  constexpr float middle = 0.5F * static_cast<float>(fewest_entries - 1);
  constexpr float spread = middle * (middle + 1.0F) / 3.0F;  // mean square distance from the middle
  const float place = static_cast<float>(clean - 1) - middle;
  level_ += unexpected_ * (1.0F / static_cast<float>(fewest_entries));
  slope_ += unexpected_ * place * (1.0F / (static_cast<float>(fewest_entries) * spread));
  square_ += unexpected_ * unexpected_;
  if (clean < fewest_entries) return;
  changed_ = event_ = false;
  const float around =
      square_ / static_cast<float>(fewest_entries) - level_ * level_ - slope_ * slope_ * spread;
  if (!bank_.resume(level_, slope_, clean, around)) restart_memory();
  newest_phase_ = newest_seen_;
}

void PhaseTracker::learn(int clean, std::uint32_t step) {
  const int now = middle_ / update_step_;
  const int ahead = now + static_cast<int>(0.020F * rate_ / static_cast<float>(update_step_) + 0.5F);
  const BankSay say = bank_.say(clean, step, now, ahead);
  const int newer = static_cast<int>(cycle_) + MainsRing::final_age;
  if (say.broken && clean_ > newer) begin_change(newer, true);
  if (changed_) return coast();
  // windows that span a change would give any frequency: for a while the one from before it stays
  if (clean < fewest_entries && clean < entry_count_ && keep_hertz_ > 0)
    --keep_hertz_;
  else
    publish(say, step, now, ahead);
  if (clean < fewest_entries && coast_ > 0) coast();
  if (clean < fewest_entries) return;
  if (++since_kept_ < keep_interval) return;
  since_kept_ = 0;
  kept_[1] = coast_ > 0 ? kept_[0] : estimate_;
  kept_[0] = estimate_;
  coast_ = coast_ + keep_interval < longest_coast ? coast_ + keep_interval : longest_coast;
}

void PhaseTracker::update() {
  extrapolate(estimate_);
  notice_changes();
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
  if (phasor.amplitude < (entry_count_ == 0 ? returned_amplitude : absent_amplitude)) return absent();
  const float window_cycle = cycle_;
  const int behind = entries_within(clean_);
  if (changed_) coast();
  remember(phasor, changed_);
  bank_.note_amplitude(phasor.amplitude);
  if (behind < 2) bank_.event();
  if (changed_) compare_windows(behind);
  const auto step = static_cast<std::uint32_t>(static_cast<float>(update_step_) / cycle_ * 4294967296.0F);
  if (!changed_ && entry_count_ >= fewest_entries) learn(entries_within(spared_), step);
  watch_beat(phasor.amplitude, step);
  const int clean = entries_within(event_ ? clean_ : spared_);
  if (magnitude(cycle_ - window_cycle) > wrong_cycle * cycle_) bank_.forget_late();
  if (magnitude(cycle_ - window_cycle) > stale_window * cycle_) entry_count_ = 0, before_ = 0;
  estimate_.faults = gate(phasor, clean);
  if (estimate_.valid()) {
    gap_ = false;
    keep_hertz_ = longest_kept;
  }
}

void PhaseTracker::absent() {
  // The frequency stays, so that a mains that comes back is found at once.
  entry_count_ = before_ = 0;
  restart_memory();
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
  // while the frequency moves a window's phase exceeds that of its middle by rate / 2 times the weight's variance
  const float bent = 0.5F * rate * window_variance / (hertz * hertz);
  estimate_.phase_turns = wrap_turns(static_cast<float>(word) * 0x1p-32F + say.now + hertz * lag_ - bent);
  estimate_.frequency = hertz;
  estimate_.frequency_rate = rate;
  const float model = model_variance();
  const float tone = bank_.swings() ? 0.0F : beat_.variance();
  estimate_.variance = (say.variance_now > tone ? say.variance_now : tone) + model;
  estimate_.variance_ahead = (say.variance_ahead > tone ? say.variance_ahead : tone) + model;
  cycle_ = rate_ / hertz;
}

/// A bias that does not change is not seen in errors of predictions. It comes from what has been put in the place of
/// samples, from notches too shallow to be told from noise, and from an input that clips; turns^2.
float PhaseTracker::model_variance() const {
  const float repaired = repair_doubt * ring_.altered();
  const float clipped = clip_doubt * clipped_;
  const float hidden = hidden_doubt * ring_.hidden();
  return repaired * repaired + hidden * hidden + clipped * clipped;
}

void PhaseTracker::watch_beat(float amplitude, std::uint32_t step) {
  if (changed_) return beat_.skip();
  beat_.push(amplitude, newest_seen_, step);
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
  const bool judged = !event_ && since_change_ < changed_most;
  faults |= bit(PhaseFault::disturbed, (judged ? doubtful_ : !quiet_) || guard_.suspicious());
  return faults;
}

}  // namespace powbench::firmware
