#include "bench/fault_injections.h"

#include <array>

namespace powbench::bench {

void flip_config_bit(FaultBench& b) {
  auto& config = const_cast<firmware::ControllerConfig&>(b.controller.config());
  config.fire.hold_limit_ms ^= 1 << 20;
}

namespace {

/// One kind of lost samples per sample of the block, so that a sweep over phases meets all.
void lose_samples(FaultBench& b) {
  auto& c = b.world.causes;
  switch (b.inject_at % 5) {
    case 0:
      c.drop = true;
      break;
    case 1:
      c.repeat = true;
      break;
    case 2:
      c.freeze = true;
      break;
    case 3:
      c.overrun = true;
      break;
    default:
      c.skip = true;
      break;
  }
}

/// Main loop or background. Before the edge a background that hangs is a stale phase long before the watchdog
/// notices, so there it is always the main loop.
void hang(FaultBench& b) {
  auto& c = b.world.causes;
  (b.world.pin && b.inject_at % 2 == 0 ? c.background_hangs : c.main_loop_hangs) = true;
}

/// In the order of the faults.
constexpr std::array<Inject, firmware::fault_table.size()> injections{
    [](FaultBench& b) { b.world.causes.mains = 0.0; },
    [](FaultBench& b) { b.world.causes.mains = 0.4; },
    [](FaultBench& b) { (b.inject_at % 2 ? b.world.causes.coil_shorted : b.world.causes.comparator) = true; },
    [](FaultBench& b) { b.world.causes.switch_stuck = true; },
    [](FaultBench& b) { b.world.causes.coil_open = true; },
    [](FaultBench& b) { b.world.causes.blocks_stop = true; },
    lose_samples,
    [](FaultBench& b) { b.world.causes.host_silent = true; },
    [](FaultBench& b) { b.world.causes.brown_out = true; },
    hang,
    [](FaultBench& b) { b.crash(); },
    [](FaultBench& b) { b.world.causes.emergency_stop = true; },
    [](FaultBench&) {},
    [](FaultBench&) {},
    [](FaultBench& b) { b.world.causes.late = 15; },
    [](FaultBench& b) { b.reset(firmware::ResetCause::pin); },
    [](FaultBench& b) { b.world.causes.laser_out = true; },
    flip_config_bit,
    [](FaultBench& b) { b.world.causes.contact_stuck = true; },
    [](FaultBench& b) { b.world.causes.estimator_starves = true; },
    [](FaultBench& b) { b.world.causes.relay_stuck = true; },
    [](FaultBench& b) { b.world.causes.relay_dead = true; },
};

}  // namespace

Inject injection_of(firmware::Fault fault) {
  return injections[static_cast<std::size_t>(fault) - 1];
}

}  // namespace powbench::bench
