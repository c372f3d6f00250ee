#include "bench/fault_bench.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::bench {

using firmware::GateEdge;

namespace {
constexpr std::int64_t closing_samples = 1200;  // current until the contact touches
constexpr std::int64_t opening_samples = 800;   // and without it until it opens
constexpr std::int64_t relay_samples = 800;     // until the relay follows
constexpr std::int64_t starved_blocks = 24;
constexpr int contact_open_counts = 19'000, travel_counts = 16'000;

/// One period of the sine, so that a step costs no library call.
const std::array<float, FaultBench::cycle>& sine() {
  static const auto table = [] {
    std::array<float, FaultBench::cycle> t{};
    for (std::size_t i = 0; i < t.size(); ++i)
      t[i] = static_cast<float>(std::sin(2 * pi * static_cast<double>(i) / static_cast<double>(t.size())));
    return t;
  }();
  return table;
}
}  // namespace

firmware::ControllerConfig FaultBench::make_config() {
  firmware::ControllerConfig c;
  c.sample_rate = rate;
  c.record_length = 9000;
  c.pretrigger = 200;
  c.phase.sample_rate = static_cast<float>(rate);
  c.phase.nominal_amplitude = mains_peak;
  c.interlocks.overcurrent_counts = overcurrent;
  c.interlocks.no_current_counts = 100;
  c.interlocks.no_current_samples = 480;
  c.interlocks.stuck_on_samples = 2500;
  c.interlocks.mains_lost_counts = mains_peak / 5;
  c.interlocks.mains_lost_samples = 1600;
  c.interlocks.contact_open_counts = contact_open_counts / 2;
  c.interlocks.relay_samples = 10'000;
  c.interlocks.travel_least_counts = -1000;
  c.interlocks.travel_most_counts = 20'000;
  c.interlocks.travel_open_counts = 2000;
  c.interlocks.travel_closed_counts = 14'000;
  return c;
}

FaultBench::FaultBench(const firmware::ControllerConfig& config)
    : controller(config, storage), pristine(controller.save()) {
  scans_.resize(std::size_t{block_samples} * channel_count);
  previous_ = scans_;
}

double FaultBench::phase_turns(std::int64_t n) const {
  return static_cast<double>(n % cycle) / static_cast<double>(cycle);
}

bool FaultBench::contact_closed() const {
  return world.causes.contact_stuck || world.conducted >= closing_samples;
}

void FaultBench::set_pin(bool on, std::int64_t n) {
  if (on == world.pin) return;
  world.pin = on;
  if (on) {
    ++world.ons;
    world.pin_on_since = n;
  } else {
    world.pin_off_since = n;
    world.on_time_most = std::max(world.on_time_most, n - world.pin_on_since);
  }
}

/// The timer: edges at their ticks, the second compare channel, and the comparator's break input.
void FaultBench::drive_pin(std::int64_t n) {
  if (fire_control().gate_inhibited()) {
    world.edge_count = 0;
    return set_pin(false, n);
  }
  std::size_t left = 0;
  for (std::size_t e = 0; e < world.edge_count; ++e) {
    const GateEdge& edge = world.edges[e];
    if (edge.at.sample_at_or_after() > n) {
      world.edges[left++] = edge;
      continue;
    }
    if (edge.on) world.off_by = edge.off_by;
    set_pin(edge.on, n);
  }
  world.edge_count = left;
  if (world.pin && world.off_by.sample_at_or_after() <= n) set_pin(false, n);
  if (world.causes.comparator) set_pin(false, n);
}

/// Told by the firmware; it drops when its supply or its coil is gone.
void FaultBench::drive_relay(std::int64_t n) {
  World& w = world;
  if (const bool told = fire_control().relay_closed(); told != w.relay_told) {
    w.relay_told = told;
    w.relay_told_at = n;
  }
  if (n - w.relay_told_at >= relay_samples) w.relay_in = w.relay_told || (w.relay_in && w.causes.relay_stuck);
  if (w.causes.relay_dead) w.relay_in = false;
}

void FaultBench::sample(std::int16_t* scan) {
  const std::int64_t n = world.next;
  if (n == inject_at && inject) inject(*this);
  drive_pin(n);
  drive_relay(n);
  const Causes& c = world.causes;
  const auto& wave = sine();
  const auto at = static_cast<std::size_t>(n % cycle);
  const auto lagging = static_cast<std::size_t>((n + cycle - cycle / 6) % cycle);
  const float mains = static_cast<float>(c.mains) * wave[at];
  const float flow = wave[lagging];
  // a triac goes on conducting until its current passes through zero
  const bool zero =
      flow * wave[(lagging + static_cast<std::size_t>(cycle) - 1) % static_cast<std::size_t>(cycle)] <= 0;
  const bool supplied = world.relay_in && !c.coil_open;
  const bool conducted_before = world.conducts;
  world.conducts = supplied && (world.pin || c.switch_stuck || (world.conducts && !zero));
  if (world.conducts && !conducted_before) world.conducts_since = n;
  const auto moved = world.conducted + (world.conducts ? 1 : -1);
  world.conducted = std::clamp<std::int64_t>(moved, 0, closing_samples + opening_samples);
  if (!world.conducts && world.conducted < opening_samples) world.conducted = 0;
  const int current = c.coil_shorted ? 30'000 : (world.conducts ? static_cast<int>(coil_peak * flow) : 0);
  if (world.conducts) world.last_current = n;
  if (world.pin) world.last_on = n;
  const std::int64_t full = std::min<std::int64_t>(world.conducted, closing_samples);
  const auto travel = static_cast<int>(travel_counts * full / closing_samples);
  const auto dither = static_cast<int>(n * 2'654'435'761 >> 20 & 7);
  const auto put = [scan](Channel channel, int v) { scan[index(channel)] = static_cast<std::int16_t>(v); };
  put(Channel::mains_voltage, static_cast<int>(std::lrint(mains_peak * mains)));
  put(Channel::coil_voltage, world.conducts ? static_cast<int>(mains_peak * mains) : 0);
  put(Channel::coil_current, current);
  put(Channel::laser, c.laser_out ? 25'000 : travel + dither);
  put(Channel::contact_a, contact_closed() ? dither : contact_open_counts + dither);
  put(Channel::pvdf_a, c.force_clipped ? 32'767 : dither);
  put(Channel::pvdf_b, dither);
  put(Channel::aux, dither);
  ++world.next;
}

void FaultBench::step() {
  const std::int64_t first = world.next;
  for (std::size_t i = 0; i < static_cast<std::size_t>(block_samples); ++i)
    sample(&scans_[i * channel_count]);
  ++world.counter;
  watch();
  if (world.causes.blocks_stop) return;
  Causes& c = world.causes;
  firmware::Block block{.first_sample = first, .scans = scans_};
  if (c.repeat) block.scans = previous_;
  if (c.freeze)
    for (std::size_t i = channel_count; i < scans_.size(); ++i) scans_[i] = scans_[i % channel_count];
  if (c.drop) {
    block.first_sample += 3;
    block.scans = block.scans.subspan(3 * channel_count);
  }
  if (c.skip) ++world.counter;
  block.emergency_stop = c.emergency_stop;
  block.comparator_trip = c.comparator;
  block.overrun = c.overrun;
  block.brown_out = c.brown_out;
  block.clock_failed = c.clock_failed;
  block.relay_in = world.relay_in;
  block.owner_present = !c.host_silent;
  block.counter = world.counter;
  block.late = c.late;
  c.drop = c.repeat = c.freeze = c.overrun = c.skip = false;
  for (const GateEdge& e : controller.control(block)) {
    if (world.edge_count < world.edges.size()) world.edges[world.edge_count++] = e;
  }
  if (++world.starved >= (c.estimator_starves ? starved_blocks : 1) && !c.background_hangs) {
    world.starved = 0;
    controller.background();
    feed.progress(firmware::WatchdogFeed::Part::background);
  }
  std::copy(scans_.begin(), scans_.end(), previous_.begin());
  feed.progress(firmware::WatchdogFeed::Part::control_interrupt);
}

/// Main loop and hardware watchdog.
void FaultBench::watch() {
  using Part = firmware::WatchdogFeed::Part;
  if (!world.causes.main_loop_hangs) {
    feed.progress(Part::main_loop);
    feed.progress(Part::communication);
  }
  if (feed.may_feed()) world.last_feed = world.next;
  if (!world.causes.blocks_stop && world.next - world.last_feed > watchdog_limit)
    reset(firmware::ResetCause::watchdog);
}

void FaultBench::run(std::int64_t samples) {
  for (const std::int64_t end = world.next + samples; world.next < end;) step();
}

void FaultBench::reset(firmware::ResetCause cause) {
  set_pin(false, world.next);
  world.edge_count = 0;
  world.last_feed = world.next;
  world.causes.main_loop_hangs = world.causes.background_hangs = false;
  controller.restore(pristine);
  fire_control().boot({.cause = cause, .survivor = &survivor});
}

void FaultBench::crash() {
  set_pin(false, world.next);
  survivor.record_crash(firmware::CrashCause::hard_fault, 0x08001234U, 0x08005678U);
  reset(firmware::ResetCause::software);
}

void FaultBench::arm() {
  fire_control().arm();
  for (int i = 0; i < 5000 && !fire_control().phase().valid(); ++i) step();
}

}  // namespace powbench::bench
