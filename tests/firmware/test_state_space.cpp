#include <catch2/catch.hpp>
#include <deque>
#include <map>
#include <set>

#include "core/random.h"
#include "tests/firmware/shot_watch.h"

using namespace powbench;
using bench::FaultBench;
using firmware::Refusal;
using firmware::State;
using test::ShotWatch;

/// The states of the real controller, explored breadth first: from every state every command, every cause that
/// appears or goes, every reset and several lapses of time. States count as the same when they agree in all
/// that decides what a command or a block does next (timers by the thresholds they have passed).

namespace {

struct Node {
  FaultBench::Snapshot bench;
  ShotWatch watch;
  firmware::Survivor survivor;
};

struct Explorer {
  FaultBench bench;
  int causes_at_once = 1;
  std::map<std::uint64_t, std::string> seen;
  std::deque<Node> open;
  std::set<int> faults;
  std::uint64_t transitions = 0;

  std::uint64_t key(const ShotWatch& watch) {
    const auto& f = bench.fire_control();
    const auto& w = bench.world;
    auto causes = w.causes;
    std::uint64_t k = 0;
    const auto add = [&k](std::uint64_t value, unsigned bits) { k = k << bits | value; };
    for (int c = 0; c < test::cause_count; ++c) add(test::cause(causes, c) ? 1 : 0, 1);
    add(causes.mains < 0.5 ? 1 : 0, 1);
    add(causes.late > 0 ? 1 : 0, 1);
    add(static_cast<std::uint64_t>(f.state()), 3);
    add(static_cast<std::uint64_t>(f.fault()), 5);
    add(f.gate_on() ? 1 : 0, 1);
    add(w.pin ? 1 : 0, 1);
    add(w.edge_count > 0 ? 1 : 0, 1);
    add(f.relay_closed() ? 1 : 0, 1);
    add(f.phase().valid() ? 1 : 0, 1);
    add(f.settling() ? 1 : 0, 1);
    add(bench.controller.recorder().complete() ? 1 : 0, 1);
    add(watch.fire_open() ? 1 : 0, 1);
    add(w.conducts ? 1 : 0, 1);
    add(w.relay_in ? 1 : 0, 1);
    add(bench.contact_closed() ? 1 : 0, 1);
    add(f.touch_delay_us() > 0 ? 1 : 0, 1);
    add(f.closing_angle() > 0 ? 1 : 0, 1);
    return k;
  }

  void pass(ShotWatch& watch, std::int64_t samples) {
    for (const std::int64_t end = bench.world.next + samples; bench.world.next < end;) {
      bench.step();
      watch.look(bench);
    }
  }

  void keep(const ShotWatch& watch) {
    ++transitions;
    faults.insert(static_cast<int>(bench.fire_control().fault()));
    if (seen.emplace(key(watch), "").second) open.push_back({bench.save(), watch, bench.survivor});
  }

  template <class Act>
  void branch(const Node& node, Act act) {
    load(node);
    ShotWatch watch = node.watch;
    act(watch);
    keep(watch);
  }
  void load(const Node& node) {
    bench.restore(node.bench);
    bench.survivor = node.survivor;
  }

  /// Every fault leads to a coil without gate within two blocks.
  void check_fault(const Node& node) {
    load(node);
    if (bench.fire_control().state() != State::fault) return;
    ShotWatch watch = node.watch;
    pass(watch, 2 * FaultBench::block_samples);
    REQUIRE_FALSE(bench.world.pin);
    REQUIRE_FALSE(bench.fire_control().gate_on());
    REQUIRE(bench.fire_control().fire() != Refusal::accepted);
    REQUIRE(bench.fire_control().arm() != Refusal::accepted);
  }

  /// No dead end: once nothing is broken any more, abort leads to a bench that makes a good shot.
  void check_way_out(const Node& node) {
    load(node);
    ShotWatch watch = node.watch;
    bench.world.causes = {};
    pass(watch, 100);
    bench.fire_control().abort();
    pass(watch, 15'000);
    bench.fire_control().abort();
    REQUIRE(bench.fire_control().state() == State::idle);
    REQUIRE(bench.fire_control().arm() == Refusal::accepted);
    for (int i = 0; i < 2000 && !bench.fire_control().phase().valid(); ++i) pass(watch, 10);
    const std::uint32_t ons = bench.world.ons;
    REQUIRE(bench.fire_control().fire() == Refusal::accepted);
    watch.fire_accepted(bench);
    for (int i = 0; i < 3000 && bench.fire_control().state() == State::firing; ++i) pass(watch, 10);
    REQUIRE(bench.fire_control().state() == State::captured);
    REQUIRE(bench.world.ons == ons + 1);
  }

  void expand(const Node& node) {
    for (int c = 0; c < test::command_count; ++c)
      branch(node, [&](ShotWatch& w) { test::command(bench, w, c); });
    for (const std::int64_t samples : {10, 300, 2500, 11'000})
      branch(node, [&](ShotWatch& w) { pass(w, samples); });
    if (node.watch.fire_open()) branch(node, [&](ShotWatch& w) { pass(w, 220'000); });
    int active = (node.bench.world.causes.mains < 0.5) + (node.bench.world.causes.late > 0);
    auto now = node.bench.world.causes;
    for (int c = 0; c < test::cause_count; ++c) active += test::cause(now, c) ? 1 : 0;
    for (int c = 0; c < test::cause_count + 2; ++c) {
      branch(node, [&](ShotWatch& w) {
        auto& causes = bench.world.causes;
        const bool on = c < test::cause_count
                            ? test::cause(causes, c)
                            : (c == test::cause_count ? causes.mains < 0.5 : causes.late > 0);
        if (!on && active >= causes_at_once) return;
        if (c < test::cause_count)
          test::cause(causes, c) = !on;
        else if (c == test::cause_count)
          causes.mains = on ? 1.0 : 0.0;
        else
          causes.late = on ? 0 : 15;
        pass(w, 10);
      });
    }
    branch(node, [&](ShotWatch& w) { bench.world.causes.drop = true, pass(w, 10); });
    branch(node, [&](ShotWatch& w) { bench.reset(firmware::ResetCause::pin), w.look(bench), pass(w, 10); });
    branch(node, [&](ShotWatch& w) { bench.crash(), w.look(bench), pass(w, 10); });
  }

  void explore(std::size_t most) {
    bench.fire_control().boot({.cause = firmware::ResetCause::pin, .survivor = &bench.survivor});
    ShotWatch watch;
    pass(watch, FaultBench::cycle);
    keep(watch);
    while (!open.empty() && seen.size() < most) {
      const Node node = open.front();
      open.pop_front();
      check_fault(node);
      check_way_out(node);
      expand(node);
    }
  }
};

}  // namespace

TEST_CASE("no state of fire control is unsafe or a dead end: nothing broken", "[fault]") {
  Explorer e;
  e.causes_at_once = 0;
  e.explore(100'000);
  WARN(e.seen.size() << " states, " << e.transitions << " transitions, " << e.faults.size() << " faults");
  CHECK(e.open.empty());
}

TEST_CASE("no state of fire control is unsafe or a dead end: one thing broken at a time", "[.slow]") {
  Explorer e;
  e.causes_at_once = 1;
  e.explore(1'000'000);
  WARN(e.seen.size() << " states, " << e.transitions << " transitions, " << e.faults.size() << " faults");
  CHECK(e.open.empty());
}
