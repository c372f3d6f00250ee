#pragma once

#include <catch2/catch.hpp>

#include "bench/fault_bench.h"

/// What must hold at every block of every history of a bench, whatever is commanded and whatever breaks.
namespace powbench::test {

class ShotWatch {
 public:
  using FaultBench = bench::FaultBench;

  /// To be called after every accepted command and every block.
  void look(const FaultBench& b) {
    const auto& f = b.fire_control();
    const auto& w = b.world;
    const bool firing = f.state() == firmware::State::firing;
    must((f.state() == firmware::State::fault) == (f.fault() != firmware::Fault::none),
         "a fault without its state");
    // an edge is committed on the estimate that the block before has left, or on one that is out of date by now
    const bool valid = f.phase().valid(edge_horizon, firmware::PhaseEstimate::usual_tolerance);
    if (f.operations() > operations_) {
      must(f.operations() == operations_ + 1, "two edges in one block");
      must(valid || valid_before_, "committed on an invalid phase");
      must(firmware::PhaseEstimate::coverage_factor * f.angle_deviation() <=
               firmware::PhaseEstimate::usual_tolerance,
           "committed on a phase that was not known within a degree");
    }
    operations_ = f.operations();  // a reset counts from zero
    valid_before_ = valid;
    // energised: only by arm and fire, once each
    if (w.ons != ons_) {
      must(w.ons == ons_ + 1, "two edges in one block");
      must(fire_open_, "energised without fire");
      fire_open_ = false;
      ons_ = w.ons;
    }
    if (!firing) fire_open_ = false;
    // on only while firing; the pin follows at the start of the next block
    if (firing) firing_at_ = w.next;
    must(!w.pin || w.next <= firing_at_ + FaultBench::block_samples, "energised outside of a shot");
    // never longer than asked for
    must(!w.pin || w.next - w.pin_on_since <= hold_ + FaultBench::block_samples, "energised too long");
    must(w.on_time_most <= most_hold_, "energised longer than asked for");
  }
  void fire_accepted(const FaultBench& b) {
    fire_open_ = true;
    ++fires_;
    hold_ = b.fire_control().hold_time_ms() * FaultBench::rate / 1000;
    if (hold_ > most_hold_) most_hold_ = hold_;
  }
  std::uint32_t fires() const { return fires_; }
  bool fire_open() const { return fire_open_; }

 private:
  /// Catch's own assertions cost more than the block they would check.
  static void must(bool holds, const char* otherwise) {
    if (!holds) FAIL(otherwise);
  }

  static constexpr float edge_horizon =
      0.0F;  ///< s: an edge may follow at once; its own bound is checked beside

  std::uint32_t ons_ = 0, fires_ = 0, operations_ = 0;
  bool fire_open_ = false;  ///< fire was accepted and has not led to an edge yet
  bool valid_before_ = false;
  std::int64_t firing_at_ = -1;
  std::int64_t hold_ = 0, most_hold_ = 0;
};

/// Commands and causes by number, for tests that draw or enumerate them.
inline constexpr int command_count = 7;
inline void command(bench::FaultBench& b, ShotWatch& watch, int number) {
  auto& f = b.fire_control();
  switch (number) {
    case 0:
      f.arm();
      break;
    case 1:
      f.disarm();
      break;
    case 2:
      if (f.fire() == firmware::Refusal::accepted) watch.fire_accepted(b);
      break;
    case 3:
      f.abort();
      break;
    case 4:
      f.set_hold_time_ms(10'001);
      break;
    case 5:
      f.set_closing_angle(f.closing_angle() == 0 ? 9000 : 0);
      break;
    default:
      f.set_touch_delay_us(f.touch_delay_us() == 0 ? 4000 : 0);
      break;
  }
  watch.look(b);
}

inline constexpr int cause_count = 16;
inline bool& cause(bench::FaultBench::Causes& c, int number) {
  const std::array<bool*, cause_count> all{
      &c.coil_open,        &c.coil_shorted,      &c.comparator,    &c.switch_stuck,
      &c.contact_stuck,    &c.laser_out,         &c.force_clipped, &c.emergency_stop,
      &c.brown_out,        &c.host_silent,       &c.clock_failed,  &c.main_loop_hangs,
      &c.background_hangs, &c.estimator_starves, &c.relay_stuck,   &c.relay_dead};
  return *all[static_cast<std::size_t>(number)];
}

}  // namespace powbench::test
