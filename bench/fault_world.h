#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/block.h"

/// What stands around a controller, with everything that can break: mains, coil switch, safety relay, contact, laser,
/// converter blocks. Ideal front end, 100 kS/s, blocks of ten. Plain data: a copy is a snapshot.

namespace powbench::bench {

struct FaultWorld {
  static constexpr std::int64_t block_samples = 10;
  static constexpr std::int64_t rate = 100'000;
  static constexpr std::int64_t cycle = 2000;  ///< samples of one mains cycle, 50 Hz
  static constexpr int mains_peak = 16'000, coil_peak = 8000, overcurrent = 20'000;
  static constexpr int contact_open_counts = 19'000, travel_counts = 16'000;

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

  /// What the firmware says from one block to the next.
  struct Told {
    bool gate_inhibited = false, relay_closed = false;
  };

  /// One sample of all channels, into `scan`; the pin and the relay move first.
  void sample(std::int16_t* scan, Told);
  /// The block of these scans, with what is broken in it. `previous`: the one before.
  firmware::Block block(std::span<std::int16_t> scans, std::span<const std::int16_t> previous);
  void schedule(std::span<const firmware::GateEdge>);
  void set_pin(bool on, std::int64_t sample);
  double phase_turns(std::int64_t sample) const;
  bool contact_closed() const;

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

 private:
  void drive_pin(std::int64_t n, bool inhibited);
  void drive_relay(std::int64_t n, bool told);
};

}  // namespace powbench::bench
