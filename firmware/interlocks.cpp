#include "firmware/interlocks.h"

namespace powbench::firmware {

namespace {

std::int32_t magnitude(std::int32_t x) {
  return x < 0 ? -x : x;
}

/// One channel of a block, from its newest sample backwards: what is looked for is mostly found at once.
struct Backwards {
  Backwards(const Block& block, Channel channel)
      : count(static_cast<std::int32_t>(block.samples())),
        newest(block.scans.data() + static_cast<std::size_t>(count - 1) * channel_count + index(channel)) {}

  /// Index of the newest sample at or before `from` for which `holds`; -1: there is none.
  template <class Condition>
  std::int32_t last(std::int32_t from, Condition holds) const {
    const std::int16_t* at = newest - (count - 1 - from) * static_cast<std::int32_t>(channel_count);
    for (; from >= 0; --from, at -= channel_count)
      if (holds(*at)) return from;
    return -1;
  }
  template <class Condition>
  std::int32_t last(Condition holds) const {
    return last(count - 1, holds);
  }

  std::int32_t count;
  const std::int16_t* newest;
};

bool same_scan(const std::int16_t* a, const std::int16_t* b) {
  for (std::size_t c = 0; c < channel_count; ++c)
    if (a[c] != b[c]) return false;
  return true;
}

void keep_scan(std::int16_t* to, const std::int16_t* from) {
  __builtin_memcpy(to, from, channel_count * sizeof *to);
}

/// False only if no sample of either film is beyond half of its range: two channels at a time, sign against the bit
/// below it.
bool force_is_large(const Block& block) {
  static_assert(index(Channel::pvdf_a) == 0 && index(Channel::pvdf_b) == 1);
  const std::int16_t* at = block.scans.data();
  std::uint32_t differ = 0;
  for (auto left = static_cast<std::int32_t>(block.samples()); left > 0; --left, at += channel_count) {
    std::uint32_t pair = 0;
    __builtin_memcpy(&pair, at, sizeof pair);
    differ |= pair ^ pair << 1;
  }
  return (differ & 0x80008000U) != 0;
}

}  // namespace

void Interlocks::reset(std::int64_t sample) {
  last_mains_ = laser_good_ = contact_good_ = last_host_ = sample;
  over_ = 0;
}

/// Do the blocks follow each other, and does their content change? First and last scan stand for the block.
Fault Interlocks::check_stream(const Block& block) {
  const std::int64_t samples = block.samples();
  const std::int16_t* first = block.scans.data();
  const std::int16_t* last = first + static_cast<std::size_t>(samples - 1) * channel_count;
  const bool jump = next_sample_ >= 0 && block.first_sample != next_sample_;
  const bool skipped = counter_ >= 0 && block.counter >= 0 && block.counter != counter_ + 1;
  const bool stale = next_sample_ >= 0 && same_scan(first, kept_first_) && same_scan(last, kept_last_);
  bool stuck = samples > 1;
  for (const std::int16_t* scan = first; stuck && scan != last; scan += channel_count)
    stuck = same_scan(scan, scan + channel_count);
  keep_scan(kept_first_, first);
  keep_scan(kept_last_, last);
  counter_ = block.counter;
  next_sample_ = block.first_sample + samples;
  block_length_ = samples;
  return jump || skipped || stale || stuck || block.overrun ? Fault::samples_lost : Fault::none;
}

void Interlocks::observe_sensors(const Block& block) {
  const InterlockConfig& c = *config_;
  const std::int64_t newest = next_sample_ - 1;
  const Backwards laser(block, Channel::laser), contact(block, Channel::contact_a);
  const std::int32_t end = laser.count - 1;
  const auto in_range = [&](std::int32_t v) {
    return v >= c.travel_least_counts && v <= c.travel_most_counts;
  };
  const bool watched = c.travel_least_counts != 0 || c.travel_most_counts != 0;
  if (const std::int32_t i = watched ? laser.last(in_range) : end; i >= 0) laser_good_ = newest - end + i;

  const auto open = [&](std::int32_t v) { return v > c.contact_open_counts; };
  const auto closed = [&](std::int32_t v) { return v <= c.contact_open_counts; };
  if (c.contact_open_counts != 0) {
    const std::int32_t i = contact.last(open), k = i == end ? contact.last(closed) : end;
    if (i >= 0) last_open_ = newest - end + i;
    if (k >= 0) last_closed_ = newest - end + k;
  }
  std::int32_t good = end;
  if (c.travel_closed_counts != 0 && c.contact_open_counts != 0) {
    for (const std::int16_t* scan = block.scans.data() + static_cast<std::size_t>(end) * channel_count;
         good >= 0; --good, scan -= channel_count) {
      const std::int32_t travel = scan[index(Channel::laser)];
      const bool against = open(scan[index(Channel::contact_a)]) ? travel > c.travel_closed_counts
                                                                 : travel < c.travel_open_counts;
      if (!against) break;
    }
  }
  if (good >= 0) contact_good_ = newest - end + good;

  const auto clipped = [&](std::int32_t v) { return magnitude(v) > c.saturation_counts; };
  if (force_is_large(block) && (Backwards(block, Channel::pvdf_a).last(clipped) >= 0 ||
                                Backwards(block, Channel::pvdf_b).last(clipped) >= 0))
    marks_ |= bit(Mark::force_saturated);
}

void Interlocks::observe_current(const Block& block) {
  if (!current_known_) return;
  const InterlockConfig& c = *config_;
  const std::int64_t first = next_sample_ - block_length_;
  const Backwards current(block, Channel::coil_current);
  const std::int32_t zero = c.current_zero_counts;
  const auto flows = [&](std::int32_t v) { return magnitude(v - zero) > c.no_current_counts; };
  const std::int32_t last = current.last(flows);
  if (last < 0) {  // the trip level is above this one
    over_ = 0;
    return;
  }
  std::int32_t began = 0;
  while (!flows(block.at(began, Channel::coil_current))) ++began;
  // an alternating current passes through zero: a run ends when it is away for half the time allowed
  if (first + began - last_current_ > c.stuck_on_samples / 2) current_since_ = first + began;
  last_current_ = first + last;

  // one sample of any two neighbours is looked at; only when that is above the level are all of them
  bool above = over_ > 0;
  for (std::int32_t i = current.count - 1; i >= 0 && !above; i -= 2)
    above = magnitude(block.at(i, Channel::coil_current) - zero) > c.overcurrent_counts;
  if (!above) return;
  for (std::int32_t i = 0; i < current.count; ++i) {
    over_ = magnitude(block.at(i, Channel::coil_current) - zero) > c.overcurrent_counts ? over_ + 1 : 0;
    if (over_ >= 2) over_tripped_ = true;
  }
}

void Interlocks::observe(const Block& block) {
  const InterlockConfig& c = *config_;
  marks_ = 0;
  over_tripped_ = block.comparator_trip;
  const Backwards mains(block, Channel::mains_voltage);
  const std::int32_t there = mains.last([&](std::int32_t v) { return magnitude(v) > c.mains_lost_counts; });
  if (there >= 0) last_mains_ = next_sample_ - mains.count + there;
  observe_current(block);
  observe_sensors(block);
  if (next_sample_ - laser_good_ > c.implausible_samples) marks_ |= bit(Mark::laser_range);
  if (next_sample_ - contact_good_ > c.implausible_samples) marks_ |= bit(Mark::contact_travel);
  if (host_heard_ || block.owner_present) last_host_ = next_sample_;
  host_heard_ = false;
  emergency_stop_ = block.emergency_stop;
  brown_out_ = block.brown_out;
  clock_failed_ = block.clock_failed;
}

Fault Interlocks::judge_coil(const GateView& gate) const {
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

Fault Interlocks::judge_relay(const Block& block, const GateView& gate) {
  relay_in_ = block.relay_in;
  if (!relay_in_) relay_out_ = next_sample_;
  if (relay_in_ == gate.relay) {
    relay_agreed_ = next_sample_;
    return Fault::none;
  }
  const std::int64_t since = relay_agreed_ > gate.relay_since ? relay_agreed_ : gate.relay_since;
  if (config_->relay_samples == 0 || next_sample_ - since <= config_->relay_samples) return Fault::none;
  return gate.relay ? Fault::relay_open : Fault::relay_welded;
}

Fault Interlocks::check(const Block& block, const GateView& gate) {
  const Fault stream = check_stream(block);
  observe(block);
  const Fault relay = judge_relay(block, gate);
  // a supply that sags reaches the gate by the same way as the comparator: it is named first
  if (brown_out_) return Fault::brown_out;
  if (over_tripped_) return Fault::coil_overcurrent;
  if (clock_failed_) return Fault::config_corrupt;
  const Fault coil = judge_coil(gate);
  if (coil != Fault::none && info(coil).watch == Watch::always) return coil;
  if (relay == Fault::relay_welded) return relay;
  if (stream != Fault::none) return stream;
  if (emergency_stop_) return Fault::emergency_stop;
  if (next_sample_ - last_mains_ > config_->mains_lost_samples) return Fault::mains_lost;
  if (coil != Fault::none) return coil;
  if (relay != Fault::none) return relay;
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
    case Fault::relay_welded:
      return relay_in_;
    case Fault::contact_welded:  // closed now, and not only for the moment of a bounce
      return config_->contact_open_counts != 0 && next_sample_ - last_open_ > config_->contact_open_samples;
    default:
      return false;
  }
}

}  // namespace powbench::firmware
