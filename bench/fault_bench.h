#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firmware/controller.h"
#include "firmware/survivor.h"
#include "firmware/watchdog_feed.h"

/// A board around the portable firmware, with everything that can break: mains, coil switch, safety relay,
/// contact, laser, converter blocks, host, watchdog and reset. Ideal front end, 100 kS/s, blocks of ten.

namespace powbench::bench {

struct FaultBench {
  static constexpr std::int64_t block_samples = 10;
  static constexpr std::int64_t rate = 100'000;
  static constexpr std::int64_t cycle = 2000;           ///< samples of one mains cycle, 50 Hz
  static constexpr std::int64_t watchdog_limit = 5000;  ///< samples without feeding until the reset
  static constexpr int mains_peak = 16'000, coil_peak = 8000, overcurrent = 20'000;

  /// What is broken now. Default: nothing.
  struct Causes {
    double mains = 1.0;          ///< factor on its amplitude
    bool coil_open = false;      ///< no current whatever the switch does
    bool coil_shorted = false;   ///< the converter reads far more than the trip level
    bool comparator = false;     ///< the same, seen by the comparator, which cuts the pin
    bool switch_stuck = false;   ///< coil switch conducts without a gate
    bool relay_stuck = false;    ///< the safety relay does not open
    bool relay_dead = false;     ///< the safety relay does not close
    bool contact_stuck = false;  ///< contact closed whatever the coil does
    bool laser_out = false;      ///< laser beyond its range
    bool force_clipped = false;  ///< film A at full scale
    bool emergency_stop = false, brown_out = false, clock_failed = false;
    bool host_silent = false;
    bool blocks_stop = false;  ///< the interrupt does not run: no block is handed over
    bool main_loop_hangs = false;
    bool background_hangs = false;
    bool estimator_starves = false;  ///< the background runs once in 2.4 ms
    std::int64_t late = 0;           ///< samples between the end of a block and its processing
    bool drop = false, repeat = false, freeze = false, overrun = false, skip = false;  ///< next block only
  };

  /// All that changes, apart from the firmware.
  struct World {
    Causes causes;
    std::int64_t next = 0;  ///< next sample
    bool pin = false;       ///< gate pin
    bool conducts = false;  ///< the switch conducts until its current's zero crossing
    std::array<firmware::GateEdge, 4> edges{};
    std::size_t edge_count = 0;
    firmware::Tick off_by{};     ///< second compare channel
    std::int64_t conducted = 0;  ///< samples the coil has conducted lately, saturates: moves the contact
    std::int64_t pin_on_since = 0, pin_off_since = 0;
    std::int64_t last_on = -1;        ///< last sample with the pin on
    std::int64_t last_current = -1;   ///< last sample with coil current
    std::uint32_t ons = 0;            ///< how often the pin went on
    std::int64_t on_time_most = 0;    ///< longest time on, samples
    std::int64_t conducts_since = 0;  ///< sample at which the coil last began to conduct
    std::int64_t last_feed = 0;
    std::int64_t counter = 0;
    std::int64_t starved = 0;  ///< blocks since the background last ran
    std::int16_t laser = 0;
    bool relay_in = false, relay_told = false;
    std::int64_t relay_told_at = 0;  ///< sample at which the relay was last told something else
  };
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
  double phase_turns(std::int64_t sample) const;
  bool contact_closed() const;

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
  void sample(std::int16_t* scan);
  void drive_pin(std::int64_t n);
  void drive_relay(std::int64_t n);
  void set_pin(bool on, std::int64_t n);
  void hand_over(std::span<const std::int16_t> scans);
  void watch();

  std::vector<std::int16_t> scans_, previous_;
};

}  // namespace powbench::bench
