#include "firmware/phase_tracker.h"

#include "firmware/math.h"
#include "firmware/phase_fit.h"

namespace powbench::firmware {

namespace {

constexpr float history_rate = 10000.0F;      ///< Hz, wanted
constexpr float lowest_valid_hertz = 44.85F;  ///< 45 .. 65 Hz, with what the estimate may be off
constexpr float highest_valid_hertz = 65.15F;
constexpr float absent_amplitude = 0.2F;  ///< of nominal: below it there is no mains
constexpr float lowest_amplitude = 0.7F;  ///< of nominal
constexpr float highest_amplitude = 1.2F;
constexpr float largest_residual = 0.15F;      ///< rms, of the fundamental's
constexpr float largest_scatter = 1.0F / 360;  ///< turns rms, phases about their fit
constexpr float cross_check_limit = 3.0F / 360;
constexpr float third_opinion_limit = 5.0F / 360;
constexpr int loud_entries = 32;        ///< the same when the mains is noisy
constexpr int fewest_entries = 18;      ///< phasors a valid estimate rests on
constexpr float shortest_span = 0.9F;   ///< cycles of phasors fitted when the mains is quiet ...
constexpr float longest_span = 3.1F;    ///< ... and when it is not
constexpr float quiet_noise = 0.0015F;  ///< of nominal amplitude
constexpr float loud_noise = 0.004F;
constexpr float quiet_weight = 0.3F;     ///< of the noise in the fit, likewise
constexpr float loud_weight = 3.5F;      ///< neighbouring phasors share most of their samples
constexpr int longest_memory = 1 << 14;  ///< samples of the history
constexpr float expected_rate = 0.5F;    ///< Hz/s, one standard deviation
constexpr float least_noise = 3.0e-4F;   ///< of nominal amplitude
constexpr float stale_window = 0.01F;    ///< a window this much off in length is not used

float magnitude(float x) {
  return x < 0.0F ? -x : x;
}
/// 0 = the mains repeats itself, 1 = as noisy as is expected.
float loudness(float noise) {
  const float loud = (noise - quiet_noise) / (loud_noise - quiet_noise);
  return loud < 0.0F ? 0.0F : (loud > 1.0F ? 1.0F : loud);
}
std::uint16_t bit(PhaseFault fault, bool set) {
  return set ? static_cast<std::uint16_t>(fault) : std::uint16_t{0};
}

}  // namespace

PhaseTracker::PhaseTracker(const PhaseTrackerConfig& config)
    : config_(config),
      decimation_(static_cast<int>(config.sample_rate / history_rate + 0.5F)),
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
  noise_ = 0.0F;
  cycle_ = rate_ / config_.nominal_hertz;
  estimate_ = no_estimate(config_.nominal_hertz);
}

void PhaseTracker::restart() {
  ring_.reset();
  compare_.reset();
  entry_count_ = newest_entry_ = 0;
  sum_ = 0;
  summed_ = since_update_ = clean_ = 0;
  quiet_ = false;
  fit_rms_ = 0.0F;
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

/// One more point of the history.
bool PhaseTracker::take(std::int32_t sum) {
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

const PhaseTracker::Entry& PhaseTracker::entry(int updates_ago) const {
  return entries_[static_cast<unsigned>((newest_entry_ - updates_ago + max_entries) % max_entries)];
}

int PhaseTracker::clean_entries(int most) const {
  int clean = 0;
  while (clean < entry_count_ && clean < most) {
    const Entry& candidate = entry(clean);
    const float reach = static_cast<float>(clean * update_step_) + window_cycles * candidate.cycle;
    if (reach > static_cast<float>(clean_) || magnitude(candidate.cycle - cycle_) > stale_window * cycle_)
      break;
    ++clean;
  }
  return clean;
}

int PhaseTracker::wanted_entries() const {
  // A short memory follows a change of the frequency sooner, a long one averages what does not repeat.
  const float span = shortest_span + loudness(noise_) * (longest_span - shortest_span);
  const auto entries = static_cast<int>(span * cycle_ / static_cast<float>(update_step_));
  return entries > fewest_entries ? entries : fewest_entries;
}

void PhaseTracker::update() {
  estimate_.sample = sample_;
  quiet_ = compare_.judge();
  if (compare_.changing() && clean_ > static_cast<int>(cycle_) + MainsRing::final_age)
    clean_ = static_cast<int>(cycle_) + MainsRing::final_age;
  // Without a history to go by, the zero crossings say where to look.
  const float crossing_hertz = zero_cross_.hertz();
  if (entry_count_ == 0 && zero_cross_.ready() && crossing_hertz > lowest_hertz &&
      crossing_hertz < highest_hertz) {
    cycle_ = rate_ / crossing_hertz;
  }
  if (ring_.count() < static_cast<std::int32_t>(window_cycles * cycle_) + 2) {
    estimate_.faults = static_cast<std::uint16_t>(PhaseFault::warming_up) | bit(PhaseFault::gap, gap_);
    return;
  }
  const WindowPhasor phasor = window_phasor(ring_, cycle_);
  estimate_.amplitude = phasor.amplitude * config_.nominal_amplitude;
  if (phasor.amplitude < absent_amplitude) return absent();
  newest_entry_ = (newest_entry_ + 1) % max_entries;
  entries_[static_cast<unsigned>(newest_entry_)] = {phasor.turns, phasor.age, cycle_};
  if (entry_count_ < max_entries) ++entry_count_;
  noise_ += 0.05F * (compare_.noise() - noise_);

  const int wanted = wanted_entries();
  const int clean = clean_entries(wanted > loud_entries ? wanted : loud_entries);  // nobody asks for more
  const int least = entry_count_ < fewest_entries ? entry_count_ : fewest_entries;
  const int most = clean < wanted ? clean : wanted;
  fit(most > least ? most : least, entry(0));
  estimate_.faults = gate(phasor, clean);
  if (estimate_.valid()) gap_ = false;
}

void PhaseTracker::absent() {
  // The frequency stays, so that a mains that comes back is found at once.
  entry_count_ = 0;
  fit_rms_ = 0.0F;
  estimate_.frequency_rate = 0.0F;
  estimate_.faults = static_cast<std::uint16_t>(PhaseFault::warming_up) |
                     static_cast<std::uint16_t>(PhaseFault::amplitude) | bit(PhaseFault::gap, gap_) |
                     bit(PhaseFault::disturbed, !quiet_);
  zero_cross_.reset();
}

void PhaseTracker::fit(int entries, const Entry& newest) {
  std::array<PhasePoint, max_entries> points;
  const float window_hertz = rate_ / newest.cycle;
  const float newest_time = -(newest.age / rate_ + lag_);
  for (int i = 0; i < entries; ++i) {
    const Entry& old = entry(i);
    const float time = -(old.age / rate_ + lag_) - static_cast<float>(i * update_step_) / rate_;
    points[static_cast<unsigned>(i)] = {
        wrap_half(old.turns - newest.turns + window_hertz * (newest_time - time)), time};
  }
  // Phase noise of the ten samples behind one point: sqrt(2 / 10) noise / amplitude, rad.
  const float amplitude = estimate_.amplitude / config_.nominal_amplitude;
  const float size = amplitude > 0.1F ? amplitude : 0.1F;
  const float weight = quiet_weight + loudness(noise_) * (loud_weight - quiet_weight);
  const float noise = (noise_ > least_noise ? noise_ : least_noise) * 0.0712F * weight / size;
  const PhaseFit result = fit_phase({points.data(), static_cast<unsigned>(entries)}, noise, expected_rate);
  fit_rms_ = result.rms;
  const float hertz = clamp_hertz(window_hertz + result.hertz);
  estimate_.phase_turns = wrap_turns(newest.turns - window_hertz * newest_time + result.turns);
  estimate_.frequency = hertz;
  estimate_.frequency_rate = result.rate;
  cycle_ = rate_ / hertz;
}

std::uint16_t PhaseTracker::gate(const WindowPhasor& phasor, int clean) const {
  const float hertz = estimate_.frequency;
  // The other two stand where the history has become final.
  const float final_lag = lag_ + static_cast<float>(MainsRing::final_age) / rate_;
  const float then = wrap_turns(estimate_.phase_turns - hertz * final_lag);
  const auto more =
      static_cast<int>(loudness(compare_.noise()) * static_cast<float>(loud_entries - fewest_entries));
  const bool enough = clean >= fewest_entries + more;
  const bool zero_cross_agrees = zero_cross_.ready() && zero_cross_.since_crossing() < cycle_ &&
                                 magnitude(wrap_half(zero_cross_.turns() - then)) <= third_opinion_limit;
  std::uint16_t faults = 0;
  faults |= bit(PhaseFault::warming_up, !enough);
  faults |= bit(PhaseFault::amplitude,
                !(phasor.amplitude >= lowest_amplitude && phasor.amplitude <= highest_amplitude));
  faults |= bit(PhaseFault::frequency, !(hertz >= lowest_valid_hertz && hertz <= highest_valid_hertz));
  faults |=
      bit(PhaseFault::residual, !(phasor.residual <= largest_residual) || !(fit_rms_ <= largest_scatter));
  faults |= bit(PhaseFault::cross_check, !(magnitude(wrap_half(pll_.turns() - then)) <= cross_check_limit));
  faults |= bit(PhaseFault::third_opinion, !zero_cross_agrees);
  faults |= bit(PhaseFault::gap, gap_ && !enough);
  faults |= bit(PhaseFault::disturbed, !quiet_);
  return faults;
}

}  // namespace powbench::firmware
