#include "bench/fault_bench.h"

#include <algorithm>

namespace powbench::bench {

namespace {
constexpr std::int64_t starved_blocks = 24;

}  // namespace

firmware::ControllerConfig FaultBench::make_config() {
  firmware::ControllerConfig c;
  c.sample_rate = rate;
  c.record_length = 9000;
  c.pretrigger = 200;
  c.phase.sample_rate = static_cast<float>(rate);
  c.phase.nominal_amplitude = World::mains_peak;
  c.interlocks.overcurrent_counts = World::overcurrent;
  c.interlocks.no_current_counts = 100;
  c.interlocks.no_current_samples = 480;
  c.interlocks.stuck_on_samples = 2500;
  c.interlocks.mains_lost_counts = World::mains_peak / 5;
  c.interlocks.mains_lost_samples = 1600;
  c.interlocks.contact_open_counts = World::contact_open_counts / 2;
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

void FaultBench::step() {
  for (std::size_t i = 0; i < static_cast<std::size_t>(block_samples); ++i) {
    if (world.next == inject_at && inject) inject(*this);
    world.sample(&scans_[i * channel_count],
                 {fire_control().gate_inhibited(), fire_control().relay_closed()});
  }
  ++world.counter;
  watch();
  if (world.causes.blocks_stop) return;
  const firmware::Block block = world.block(scans_, previous_);
  world.schedule(controller.control(block));
  if (++world.starved >= (world.causes.estimator_starves ? starved_blocks : 1) &&
      !world.causes.background_hangs) {
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
  world.set_pin(false, world.next);
  world.edge_count = 0;
  world.last_feed = world.next;
  world.causes.main_loop_hangs = world.causes.background_hangs = false;
  controller.restore(pristine);
  fire_control().boot({.cause = cause, .survivor = &survivor});
}

void FaultBench::crash() {
  world.set_pin(false, world.next);
  survivor.record_crash(firmware::CrashCause::hard_fault, 0x08001234U, 0x08005678U);
  reset(firmware::ResetCause::software);
}

void FaultBench::arm() {
  fire_control().arm();
  for (int i = 0; i < 5000 && !fire_control().phase().valid(); ++i) step();
}

}  // namespace powbench::bench
