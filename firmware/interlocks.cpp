#include "firmware/interlocks.h"

namespace powbench::firmware {

namespace {

std::int32_t magnitude(std::int32_t x) {
  return x < 0 ? -x : x;
}

/// Content of a block in one word, and whether all its scans are the same.
std::uint32_t content_of(const Block& block, bool& all_equal) {
  std::uint32_t hash = 2166136261U;
  all_equal = true;
  for (std::size_t i = 0; i < block.scans.size(); ++i) {
    hash = hash * 31U + static_cast<std::uint16_t>(block.scans[i]);
    if (i >= channel_count) all_equal = all_equal && block.scans[i] == block.scans[i - channel_count];
  }
  return hash;
}

}  // namespace

void Interlocks::reset(std::int64_t sample) {
  last_mains_ = laser_good_ = contact_good_ = last_host_ = sample;
  over_ = 0;
}

/// Do the blocks follow each other, and does their content change?
Fault Interlocks::check_stream(const Block& block) {
  bool stuck = false;
  const std::uint32_t content = content_of(block, stuck);
  const bool jump = next_sample_ >= 0 && block.first_sample != next_sample_;
  const bool skipped = counter_ >= 0 && block.counter >= 0 && block.counter != counter_ + 1;
  const bool stale = next_sample_ >= 0 && content == content_;
  stuck = stuck && block.samples() > 1;
  content_ = content;
  counter_ = block.counter;
  next_sample_ = block.first_sample + block.samples();
  block_length_ = block.samples();
  return jump || skipped || stale || stuck || block.overrun ? Fault::samples_lost : Fault::none;
}

void Interlocks::observe_sensors(const Block& block, std::int64_t sample, std::int64_t i) {
  const InterlockConfig& c = *config_;
  const std::int32_t laser = block.at(i, Channel::laser);
  const bool open = block.at(i, Channel::contact_a) > c.contact_open_counts;
  if (open)
    last_open_ = sample;
  else if (c.contact_open_counts != 0)
    last_closed_ = sample;
  const bool watched = c.travel_least_counts != 0 || c.travel_most_counts != 0;
  if (!watched || (laser >= c.travel_least_counts && laser <= c.travel_most_counts)) laser_good_ = sample;
  const bool against = open ? laser > c.travel_closed_counts : laser < c.travel_open_counts;
  if (!against || c.travel_closed_counts == 0 || c.contact_open_counts == 0) contact_good_ = sample;
  if (magnitude(block.at(i, Channel::pvdf_a)) > c.saturation_counts ||
      magnitude(block.at(i, Channel::pvdf_b)) > c.saturation_counts)
    marks_ |= bit(Mark::force_saturated);
}

void Interlocks::observe(const Block& block) {
  const InterlockConfig& c = *config_;
  marks_ = 0;
  over_tripped_ = block.comparator_trip;
  for (std::int64_t i = 0; i < block.samples(); ++i) {
    const std::int64_t sample = block.first_sample + i;
    const std::int32_t current = magnitude(block.at(i, Channel::coil_current));
    if (magnitude(block.at(i, Channel::mains_voltage)) > c.mains_lost_counts) last_mains_ = sample;
    if (current > c.no_current_counts) {
      // an alternating current passes through zero: a run ends when it is away for half the time allowed
      if (sample - last_current_ > c.stuck_on_samples / 2) current_since_ = sample;
      last_current_ = sample;
    }
    over_ = current > c.overcurrent_counts ? over_ + 1 : 0;
    if (over_ >= 2) over_tripped_ = true;
    observe_sensors(block, sample, i);
  }
  if (next_sample_ - laser_good_ > c.implausible_samples) marks_ |= bit(Mark::laser_range);
  if (next_sample_ - contact_good_ > c.implausible_samples) marks_ |= bit(Mark::contact_travel);
  if (block.host_heard) last_host_ = next_sample_;
  emergency_stop_ = block.emergency_stop;
  brown_out_ = block.brown_out;
  clock_failed_ = block.clock_failed;
}

Fault Interlocks::judge_coil(GateView gate) const {
  const InterlockConfig& c = *config_;
  const std::int64_t now = next_sample_;
  const std::int64_t since = now - gate.since;
  const auto silent = [&](std::int64_t last) { return now - (last > gate.since ? last : gate.since); };
  if (gate.on) {
    if (silent(last_current_) > c.no_current_samples) return Fault::coil_not_energising;
    if (silent(last_host_) > c.heartbeat_samples) return Fault::host_lost;
    return Fault::none;
  }
  const bool flows = now - last_current_ <= c.stuck_on_samples / 2;
  if (since > c.stuck_on_samples && flows && last_current_ - current_since_ >= c.stuck_on_samples)
    return Fault::coil_stuck_on;
  if (since > c.weld_samples && present(Fault::contact_welded) && coil_quiet(now))
    return Fault::contact_welded;
  return Fault::none;
}

Fault Interlocks::check(const Block& block, GateView gate) {
  const Fault stream = check_stream(block);
  observe(block);
  if (over_tripped_) return Fault::coil_overcurrent;
  if (brown_out_) return Fault::brown_out;
  if (clock_failed_) return Fault::config_corrupt;
  const Fault coil = judge_coil(gate);
  if (coil != Fault::none && info(coil).watch == Watch::always) return coil;
  if (stream != Fault::none) return stream;
  if (emergency_stop_) return Fault::emergency_stop;
  if (next_sample_ - last_mains_ > config_->mains_lost_samples) return Fault::mains_lost;
  if (coil != Fault::none) return coil;
  constexpr std::uint8_t implausible = bit(Mark::laser_range) | bit(Mark::contact_travel);
  if (!gate.on && (marks_ & implausible) != 0) return Fault::sensor_implausible;
  return Fault::none;
}

bool Interlocks::present(Fault fault) const {
  switch (fault) {
    case Fault::coil_stuck_on:
      return !coil_quiet(next_sample_);
    case Fault::brown_out:
      return brown_out_;
    case Fault::emergency_stop:
      return emergency_stop_;
    case Fault::config_corrupt:
      return clock_failed_;
    case Fault::contact_welded:  // closed now, and not only for the moment of a bounce
      return config_->contact_open_counts != 0 && last_closed_ >= next_sample_ - block_length_ &&
             next_sample_ - last_open_ > config_->contact_open_samples;
    default:
      return false;
  }
}

}  // namespace powbench::firmware
