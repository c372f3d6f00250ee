#include "bench/fault_world.h"

#include <algorithm>
#include <cmath>

#include "core/channels.h"
#include "core/units.h"

namespace powbench::bench {

using firmware::GateEdge;

namespace {
constexpr std::int64_t closing_samples = 1200;  // current until the contact touches
constexpr std::int64_t opening_samples = 800;   // and without it until it opens
constexpr std::int64_t relay_samples = 800;     // until the relay follows

/// One period of the sine, so that a step costs no library call.
const std::array<float, FaultWorld::cycle>& sine() {
  static const auto table = [] {
    std::array<float, FaultWorld::cycle> t{};
    for (std::size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<float>(std::sin(2 * pi * static_cast<double>(i) / static_cast<double>(t.size())));
    return t;
  }();
  return table;
}
}  // namespace

double FaultWorld::phase_turns(std::int64_t n) const {
  return static_cast<double>(n % cycle) / static_cast<double>(cycle);
}

bool FaultWorld::contact_closed() const {
  return causes.contact_stuck || conducted >= closing_samples;
}

void FaultWorld::set_pin(bool on, std::int64_t n) {
  if (on == pin) return;
  pin = on;
  if (on) {
    ++ons;
    pin_on_since = n;
  } else {
    pin_off_since = n;
    on_time_most = std::max(on_time_most, n - pin_on_since);
  }
}

/// The timer: edges at their ticks, the second compare channel, and the comparator's break input.
void FaultWorld::drive_pin(std::int64_t n, bool inhibited) {
  if (inhibited) {
    edge_count = 0;
    return set_pin(false, n);
  }
  std::size_t left = 0;
  for (std::size_t e = 0; e < edge_count; ++e) {
    const GateEdge& edge = edges[e];
    if (edge.at.sample_at_or_after() > n) {
      edges[left++] = edge;
      continue;
    }
    if (edge.on) off_by = edge.off_by;
    set_pin(edge.on, n);
  }
  edge_count = left;
  if (pin && off_by.sample_at_or_after() <= n) set_pin(false, n);
  if (causes.comparator) set_pin(false, n);
}

/// Told by the firmware; it drops when its supply or its coil is gone.
void FaultWorld::drive_relay(std::int64_t n, bool told) {
  if (told != relay_told) {
    relay_told = told;
    relay_told_at = n;
  }
  if (n - relay_told_at >= relay_samples) relay_in = relay_told || (relay_in && causes.relay_stuck);
  if (causes.relay_dead) relay_in = false;
}

void FaultWorld::sample(std::int16_t* scan, Told told) {
  const std::int64_t n = next;
  drive_pin(n, told.gate_inhibited);
  drive_relay(n, told.relay_closed);
  const Causes& c = causes;
  const auto& wave = sine();
  const auto at = static_cast<std::size_t>(n % cycle);
  const auto lagging = static_cast<std::size_t>((n + cycle - cycle / 6) % cycle);
  const float mains = static_cast<float>(c.mains) * wave[at];
  const float flow = wave[lagging];
  // a triac goes on conducting until its current passes through zero
  const bool zero =
      flow * wave[(lagging + static_cast<std::size_t>(cycle) - 1) % static_cast<std::size_t>(cycle)] <= 0;
  const bool supplied = relay_in && !c.coil_open;
  const bool conducted_before = conducts;
  conducts = supplied && (pin || c.switch_stuck || (conducts && !zero));
  if (conducts && !conducted_before) conducts_since = n;
  const auto moved = conducted + (conducts ? 1 : -1);
  conducted = std::clamp<std::int64_t>(moved, 0, closing_samples + opening_samples);
  if (!conducts && conducted < opening_samples) conducted = 0;
  const int current = c.coil_shorted ? 30'000 : (conducts ? static_cast<int>(coil_peak * flow) : 0);
  if (conducts) last_current = n;
  if (pin) last_on = n;
  const std::int64_t full = std::min<std::int64_t>(conducted, closing_samples);
  const auto travel = static_cast<int>(travel_counts * full / closing_samples);
  const auto dither = static_cast<int>(n * 2'654'435'761 >> 20 & 7);
  const auto put = [scan](Channel channel, int v) { scan[index(channel)] = static_cast<std::int16_t>(v); };
  put(Channel::mains_voltage, static_cast<int>(std::lrint(mains_peak * mains)));
  put(Channel::coil_voltage, conducts ? static_cast<int>(mains_peak * mains) : 0);
  put(Channel::coil_current, current);
  put(Channel::laser, c.laser_out ? 25'000 : travel + dither);
  put(Channel::contact_a, contact_closed() ? dither : contact_open_counts + dither);
  put(Channel::pvdf_a, c.force_clipped ? 32'767 : dither);
  put(Channel::pvdf_b, dither);
  put(Channel::aux, dither);
  ++next;
}

firmware::Block FaultWorld::block(std::span<std::int16_t> scans, std::span<const std::int16_t> previous) {
  Causes& c = causes;
  firmware::Block block{.first_sample = next - block_samples, .scans = scans};
  if (c.repeat) block.scans = previous;
  if (c.freeze)
    for (std::size_t i = channel_count; i < scans.size(); ++i) scans[i] = scans[i % channel_count];
  if (c.drop) {
    block.first_sample += 3;
    block.scans = block.scans.subspan(3 * channel_count);
  }
  if (c.skip) ++counter;
  block.emergency_stop = c.emergency_stop;
  block.comparator_trip = c.comparator;
  block.overrun = c.overrun;
  block.brown_out = c.brown_out;
  block.clock_failed = c.clock_failed;
  block.relay_in = relay_in;
  block.owner_present = !c.host_silent;
  block.counter = counter;
  block.late = c.late;
  c.drop = c.repeat = c.freeze = c.overrun = c.skip = false;
  return block;
}

void FaultWorld::schedule(std::span<const GateEdge> found) {
  for (const GateEdge& e : found)
    if (edge_count < edges.size()) edges[edge_count++] = e;
}

}  // namespace powbench::bench
