#pragma once

#include <cstdint>
#include <vector>

#include "bench/fault_world.h"
#include "firmware/controller.h"
#include "firmware/survivor.h"
#include "firmware/watchdog_feed.h"

/// A board around the portable firmware: the world that can break, and host, watchdog and reset.

namespace powbench::bench {

struct FaultBench {
  using World = FaultWorld;
  using Causes = FaultWorld::Causes;
  static constexpr std::int64_t block_samples = World::block_samples, rate = World::rate,
                                cycle = World::cycle;
  static constexpr std::int64_t watchdog_limit =
      10'600;  ///< samples without feeding until the reset: the board's 100 ms, its oscillator slow

  struct Snapshot {
    World world;
    firmware::Controller::Memory memory;
  };

  static firmware::ControllerConfig make_config();
  explicit FaultBench(const firmware::ControllerConfig& = make_config());

  /// One block of time. `inject_at`: sample at whose start `inject` acts on the causes.
  void step();
  void run(std::int64_t samples);
  /// Power, pin or watchdog reset: the pin falls, the firmware starts anew.
  void reset(firmware::ResetCause);
  /// A fault handler: pin low, note in the surviving RAM, reset.
  void crash();
  /// Armed with a valid phase.
  void arm();
  double phase_turns(std::int64_t sample) const { return world.phase_turns(sample); }
  bool contact_closed() const { return world.contact_closed(); }

  Snapshot save() const { return {world, controller.save()}; }
  void restore(const Snapshot& s) {
    world = s.world;
    controller.restore(s.memory);
  }
  firmware::FireControl& fire_control() { return controller.fire_control(); }
  const firmware::FireControl& fire_control() const { return controller.fire_control(); }

  World world;
  std::int64_t inject_at = -1;
  void (*inject)(FaultBench&) = nullptr;
  firmware::Survivor survivor{};
  firmware::WatchdogFeed feed;
  std::vector<std::int16_t> storage = std::vector<std::int16_t>(std::size_t{9000} * channel_count);
  firmware::Controller controller;
  firmware::Controller::Memory pristine;

 private:
  void watch();

  std::vector<std::int16_t> scans_, previous_;
};

}  // namespace powbench::bench
