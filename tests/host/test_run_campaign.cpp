#include <catch2/catch.hpp>
#include <csignal>
#include <functional>

#include "dsp/events/extract.h"
#include "host/run/campaign.h"
#include "host/run/stop.h"
#include "host/store/begun_rows.h"
#include "host/store/open.h"
#include "tests/host/store_samples.h"

/// The loop of a campaign with a rig of words and a clock that only the test moves.

using namespace powbench;
using namespace powbench::host;

namespace {

/// Sleeping is all that makes its time pass; what was slept is noted.
class ManualClock final : public Clock {
 public:
  double now() const override { return now_; }
  void sleep(double seconds) override {
    now_ += seconds;
    naps.push_back(seconds);
    if (on_sleep) on_sleep();
  }
  std::vector<double> naps;
  std::function<void()> on_sleep;

 private:
  double now_ = 0;
};

/// Answers every shot with a record, unless told otherwise.
class WordRig final : public rigs::Rig {
 public:
  const rigs::RigInfo& info() const override { return info_; }
  rigs::Shot fire(const Conditions&, std::chrono::milliseconds) override {
    ++fired;
    if (on_fire) on_fire(fired);
    rigs::Shot shot;
    if (fired == lost_at) {
      shot.rig_lost = true;
      shot.reason = "the rig went away";
      return shot;
    }
    shot.outcome = Outcome::pass;
    shot.record = sample_record(static_cast<std::uint64_t>(fired));
    return shot;
  }
  void stop_when(std::function<bool()>) override {}
  bool abort() override { return true; }
  bool reconnect() override { return ++reconnects >= answers_from; }
  std::optional<rigs::Shot> recover(std::chrono::milliseconds) override {
    if (!holds_a_record) return std::nullopt;
    rigs::Shot shot;
    shot.outcome = Outcome::pass;
    shot.record = sample_record(static_cast<std::uint64_t>(fired));
    return shot;
  }

  int fired = 0, reconnects = 0;
  int lost_at = 0;              ///< number of the shot, from 1, at which the line breaks
  bool holds_a_record = false;  ///< of the shot at which the line broke
  int answers_from = 1;         ///< the first attempt to reconnect that succeeds
  std::function<void(int)> on_fire;

 private:
  rigs::RigInfo info_;
};

struct Campaign {
  explicit Campaign(int shots) : plan(static_cast<std::size_t>(shots)) {
    for (int i = 0; i < shots; ++i) plan[static_cast<std::size_t>(i)].index = i;
    fill(store, 0);
    options.pause = 0.5;
    options.clock = &clock;
  }
  RunSummary run() {
    Progress silent("test", plan.size(), Progress::Style::none);
    return run_campaign(store, 1, plan, rig, options, silent);
  }
  double slept() const {
    double sum = 0;
    for (const double s : clock.naps) sum += s;
    return sum;
  }

  Folder folder;
  Store store{folder.file()};
  std::vector<PlannedShot> plan;
  ManualClock clock;
  WordRig rig;
  RunOptions options;
};

}  // namespace

TEST_CASE("a shot is judged by the plan's angle tolerance and limits, and an angle not seen is no pass",
          "[run]") {
  RunOptions o;
  Conditions asked;
  asked.closing_angle = radians(60);
  Events e;
  e.coil.closing_angle = {radians(61.5), radians(0.02)};
  const auto judged = [&] {
    dsp::check_angle(e, asked, o.angle_tolerance);
    return judge_shot(e, asked, o);
  };
  CHECK(judged().outcome == Outcome::not_judged);  // no tolerance, no limit
  o.angle_tolerance = radians(1);
  CHECK(judged().outcome == Outcome::fail);
  CHECK(judged().reason == "closing angle 61.50 deg, commanded 60.00 deg, tolerance 1 deg");
  o.angle_tolerance = radians(5);
  CHECK(judged().outcome == Outcome::not_judged);
  CHECK(judged().reason.empty());
  e.coil.closing_angle = {};
  CHECK(judged().outcome == Outcome::not_observed);
  asked.closing_angle = std::nan("");  // of an import: nothing was commanded
  CHECK(judged().outcome == Outcome::not_judged);
}

TEST_CASE("a campaign pauses between two shots for as long as its plan says, and not behind the last",
          "[run]") {
  Campaign c(3);
  const RunSummary summary = c.run();
  CHECK(summary.done() == 3);
  CHECK(c.slept() == Approx(2 * 0.5));
}

TEST_CASE("a lost rig is looked for five times in 3.75 s, and the campaign goes on when it answers",
          "[run]") {
  Campaign c(3);
  c.options.pause = 0;
  c.rig.lost_at = 2;
  SECTION("at the last look") {
    c.rig.answers_from = 5;
    const RunSummary summary = c.run();
    CHECK(c.rig.fired == 3);
    CHECK_FALSE(summary.rig_lost);
    CHECK(summary.done() == 2);
    CHECK(summary.exit_code() == Exit::rig_fault);
    CHECK(c.store.shots(1).size() == 3);
  }
  SECTION("never") {
    c.rig.answers_from = 6;
    const RunSummary summary = c.run();
    CHECK(c.rig.fired == 2);
    CHECK(summary.rig_lost);
    CHECK(summary.stopped.find("--resume") != std::string::npos);
    CHECK(c.store.annotations(1).at(0).text ==
          "stopped because the rig did not come back, 1 of 3 shots recorded");
    CHECK(summary.exit_code() == Exit::rig_fault);
  }
  CHECK(c.clock.naps == std::vector<double>{0.25, 0.5, 1.0, 2.0});
}

TEST_CASE("what was fired before the rig was lost is fetched, and the failed attempt stays as history",
          "[run]") {
  Campaign c(3);
  c.rig.lost_at = 2;
  c.rig.holds_a_record = true;
  const RunSummary summary = c.run();
  CHECK(c.rig.fired == 3);
  CHECK(summary.done() == 3);
  CHECK(summary.exit_code() == Exit::pass);
  CHECK(c.store.shots(1).size() == 3);
  const auto earlier = c.store.earlier_attempts(1);
  REQUIRE(earlier.size() == 1);
  CHECK(earlier[0].number == 1);
  CHECK(earlier[0].reason == "the rig went away");
}

TEST_CASE("a shot is marked in the store before it is fired, and the mark goes with its result", "[run]") {
  Campaign c(2);
  c.rig.on_fire = [&](int fired) {
    if (fired == 1) CHECK(c.store.shots(1).empty());
    const auto begun = select_begun(open_store(c.folder.file(), Store::Mode::read_only));
    REQUIRE(begun.size() == 1);
    CHECK(begun[0].shot.number == fired - 1);
    CHECK(Store(c.folder.file()).close_begun().empty());  // it is in flight
  };
  c.run();
  CHECK(c.store.close_begun().empty());
  CHECK(c.store.shots(1).size() == 2);
  CHECK(c.store.earlier_attempts(1).empty());
}

TEST_CASE("a stop during a shot ends the campaign behind it; the shot is stored", "[run]") {
  const StopOnSignal guard;
  Campaign c(4);
  c.rig.on_fire = [](int number) {
    if (number == 2) std::raise(SIGINT);
  };
  const RunSummary summary = c.run();
  CHECK(summary.interrupted);
  CHECK(summary.exit_code() == Exit::interrupted);
  CHECK(c.rig.fired == 2);
  CHECK(c.store.shots(1).size() == 2);
  const auto course = c.store.annotations(1);
  REQUIRE(course.size() == 1);
  CHECK(course[0].key == course_key);
  CHECK(course[0].text == "stopped by the operator, 2 of 4 shots recorded");
}

TEST_CASE("a campaign that is gone on with says so, one that runs through says nothing", "[run]") {
  Campaign c(4);
  const auto rest = c.plan;
  c.plan.resize(3);
  c.run();
  CHECK(c.store.annotations(1).empty());
  c.plan = rest;
  c.run();
  const auto course = c.store.annotations(1);
  REQUIRE(course.size() == 1);
  CHECK(course[0].text == "gone on with, 3 of 4 shots recorded before");
  c.run();  // nothing is left
  CHECK(c.store.annotations(1).size() == 1);
}

TEST_CASE("a stopped single closing counts itself, not the others of its campaign", "[run]") {
  const StopOnSignal guard;
  Campaign c(3);
  c.run();
  c.plan = {c.plan.back()};
  c.plan.front().index = 3;
  std::raise(SIGINT);
  CHECK(c.run().interrupted);
  CHECK(c.store.annotations(1).at(0).text == "stopped by the operator, 0 of 1 shots recorded");
}

TEST_CASE("a stop ends a long pause and the search for a lost rig at once", "[run]") {
  const StopOnSignal guard;
  Campaign c(4);
  c.clock.on_sleep = [] { std::raise(SIGTERM); };
  SECTION("pause") {
    c.options.pause = 3600;
    CHECK(c.run().interrupted);
    CHECK(c.slept() < 0.1);
  }
  SECTION("search") {
    c.rig.lost_at = 1;
    c.rig.answers_from = 9;
    CHECK(c.run().rig_lost);
    CHECK(c.clock.naps.size() == 1);
  }
  CHECK(c.rig.fired == 1);
}
