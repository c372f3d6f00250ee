#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "core/random.h"
#include "rigs/iiod_server.h"
#include "rigs/rig_watch.h"
#include "tests/serve/served.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;

TEST_CASE("STOP: whenever it comes, nothing is fired once it is confirmed", "[serve]") {
  // a rig of its own, so that somebody else can look at it
  const rigs::LocalRig rig(rigs::SimRigConfig{}, sim::Specimen{});
  const std::string uri = "ip:" + rig.address();
  Served s(served_plan, uri);
  rigs::RigWatch other(uri, std::chrono::milliseconds(2500));
  Random random(7);
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    const bool plan = round % 2 == 0;
    if (plan)
      s.bench.run(scene_of("angles_deg = [0, 45, 90, 135]\nrepeats = 50\n"));
    else
      s.bench.fire(1.0);
    // some milliseconds of work, not of waiting: a loaded machine does not make it minutes
    const auto turns = static_cast<int>(random.uniform() * 6e6);
    for (volatile int i = 0; i < turns;) i = i + 1;
    const host::StopAnswer stopped = s.bench.stop();
    REQUIRE(stopped.off);
    REQUIRE_THAT(stopped.text, Contains("confirmed by the rig"));
    for (int i = 0; i < 20; ++i) REQUIRE_FALSE(other.status().live());
    s.until_ended();
    const std::size_t then = s.shots();
    for (int i = 0; i < 20; ++i) REQUIRE_FALSE(other.status().live());
    REQUIRE(s.shots() == then);
  }
}

TEST_CASE("STOP: from several threads at once, while somebody begins", "[serve]") {
  Served s;
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> begun = 0;
    std::thread starter([&] {
      for (int i = 0; i < 50; ++i) try {
          s.bench.fire(0.5);
          ++begun;
        } catch (const host::NotNow&) {
        }
    });
    std::atomic<int> off = 0;
    const auto press = [&] { off += s.bench.stop().off ? 1 : 0; };
    std::thread a(press), b(press);
    starter.join();
    a.join();
    b.join();
    CHECK(off == 2);
    s.until_ended();
    // what was begun behind the last stop has been fired; nothing else is on its way
    const host::StopAnswer last = s.bench.stop();
    REQUIRE(last.off);
    const auto shots = s.shots();
    CHECK(shots <= static_cast<std::size_t>(20 * 50));
    CHECK(s.state().at("job").is_null());
  }
}

TEST_CASE("STOP: a closing at touch whose angle is still sought is not fired afterwards", "[serve]") {
  Served s;
  std::string said;
  std::thread fire([&] {
    try {
      s.bench.fire_at_touch(1.5);
    } catch (const host::NotNow& e) {
      said = e.what();
    }
  });
  wait_until("the search", [&] { return s.state().at("aiming") == true; });
  CHECK_THROWS_AS(s.bench.fire(1.0), host::NotNow);  // it is not ready meanwhile
  CHECK_THROWS_AS(s.bench.fire_at_touch(1.0), host::NotNow);
  REQUIRE(s.bench.stop().off);
  CHECK(s.state().at("aiming") == false);
  fire.join();
  CHECK_THAT(said, Contains("STOP came after this was asked for"));
  s.until_ended();
  CHECK(s.shots() == 0);
  s.bench.fire_at_touch(1.5);  // asked for anew it is fired
  s.until_ended();
  CHECK(s.shots() == 1);
}

TEST_CASE("STOP: what was asked for before it and waits in a queue is not fired", "[serve]") {
  Served s;
  const auto before = host::Bench::now();
  REQUIRE(s.bench.stop().off);
  CHECK_THROWS_AS(s.bench.fire(1.0, before), host::NotNow);
  CHECK_THROWS_AS(s.bench.run(scene_of("angles_deg = [0]\nrepeats = 1\n"), before), host::NotNow);
  CHECK(s.state().at("job").is_null());
  CHECK(s.shots() == 0);
  s.bench.fire(1.0);
  s.until_ended();
  CHECK(s.shots() == 1);
}

TEST_CASE("STOP: it is told what it confirms, and when", "[serve]") {
  Served s;
  const host::StopAnswer stopped = s.bench.stop();
  CHECK_THAT(stopped.text, Catch::Matches("coil off, confirmed by the rig: gate off, coil "
                                          "current [0-9]+\\.[0-9] mA, at [0-9]{2}:[0-9]{2}:[0-9]{2} UTC"));
  // what is asked for next is not what was confirmed, also while its angle is sought
  std::thread fire([&] { s.bench.fire_at_touch(1.5); });
  wait_until("the search", [&] { return s.state().at("aiming") == true || !s.state().at("job").is_null(); });
  CHECK(s.state().at("stop").is_null());
  fire.join();
  s.until_ended();
}

TEST_CASE("STOP: one that comes when all is fired says so", "[serve]") {
  Served s;
  s.bench.run(scene_of("angles_deg = [0, 15, 30, 45, 60, 75, 90, 105, 120, 135, 150, 165]\nrepeats = 1\n"));
  wait_until("the last shot", [&] {
    const auto job = s.state().at("job");
    return !job.is_null() && job.at("doing") == "simulating";
  });
  CHECK_THAT(s.bench.stop().text, Contains("; all closings were already fired"));
  if (const auto job = s.state().at("job"); !job.is_null())
    CHECK(job.at("doing") == "all closings were already fired before STOP; simulating");
  s.until_ended();
  CHECK(s.shots() == 12);
  const std::string log = s.state().at("log").dump();
  CHECK_THAT(
      log,
      Contains("12 of 12 shots recorded, no limit is set; STOP came when all closings were already fired"));
  // and one in between is set apart in the log too
  s.bench.run(scene_of("angles_deg = [0, 90]\nrepeats = 200\n"));
  wait_until("a shot", [&] { return s.shots() > 12; });
  s.bench.stop();
  s.until_ended();
  CHECK_THAT(s.state().at("log").dump(), Contains("no limit is set; stopped"));
}

TEST_CASE("STOP: a closing that it cut is not counted as done, and shows no curves", "[serve]") {
  Served s;
  bool cut = false;
  for (int round = 0; round < 20 && !cut; ++round) {
    s.bench.run(scene_of("angles_deg = [0, 45, 90, 135]\nrepeats = 50\nhold_time_ms = 5000\n"));
    wait_until("a closing", [&] {
      const auto job = s.state().at("job");
      return job.is_null() || (job.at("done") >= 1 && job.at("doing") == "firing");
    });
    s.bench.stop();
    s.until_ended();
    const auto campaign = s.get("/api/campaigns").at(0);
    const std::size_t aborted = campaign.at("outcomes").value("ABORTED", std::size_t{0});
    CHECK(s.state().at("ended").at("done") == campaign.at("shots").get<std::size_t>() - aborted);
    cut = aborted > 0;
    if (!cut) continue;
    const auto shot = s.state().at("newest_shot").dump();
    CHECK(s.get("/api/shots/" + shot).at("outcome") == "ABORTED");
    CHECK(s.ask("GET", "/api/shots/" + shot + "/closing").status == 200);
    CHECK(s.get("/api/shots/" + shot + "/closing") == nlohmann::json::array());
  }
  CHECK(cut);
}

TEST_CASE("STOP: a single closing that it comes too late for has its simulation all the same", "[serve]") {
  Served s;
  bool late = false;
  for (int round = 0; round < 20 && !late; ++round) {
    s.bench.fire(radians(10.0 + round));
    wait_until("the shot", [&] {
      const auto now = s.state();
      return now.at("job").is_null() || now.at("job").at("done") == 1;
    });
    late = !s.state().at("job").is_null();
    s.bench.stop();
    s.until_ended();
    const auto shot = s.get("/api/shots/" + s.state().at("newest_shot").dump());
    if (shot.at("outcome") == "ABORTED") continue;
    CHECK(shot.at("quantities").at(0).at("simulated").is_number());
    wait_until("U of the simulation", [&] {
      return s.get("/api/shots/" + shot.at("id").dump()).at("quantities").at(0).at("simulated_u").is_number();
    });
  }
}

TEST_CASE("STOP: what it has confirmed is in the very next state", "[serve]") {
  Served s;
  for (int round = 0; round < 5; ++round) {
    s.bench.run(scene_of("angles_deg = [0, 90]\nrepeats = 50\nhold_time_ms = 5000\n"));
    wait_until("the coil", [&] {
      const auto status = s.state().at("status");
      return !status.is_null() && status.at("gate") == true;
    });
    const auto answer = s.bench.stop();
    const auto now = s.state();
    REQUIRE(answer.off);
    CHECK(now.at("status").at("gate") == false);
    CHECK(now.at("status").at("live") == false);
    if (!now.at("job").is_null()) CHECK(now.at("job").at("doing") == "stopping");
    s.until_ended();
    CHECK(s.state().at("log").dump().find("not the owner") == std::string::npos);
  }
}

TEST_CASE("STOP: a rig that does not answer is said loudly", "[serve]") {
  auto rig = std::make_unique<rigs::LocalRig>(rigs::SimRigConfig{}, sim::Specimen{});
  Served s(served_plan, "ip:" + rig->address());
  rig.reset();
  const host::Reply r = s.ask("POST", "/api/stop");
  CHECK(r.status == 504);
  CHECK_THAT(r.body, Contains("THE RIG DOES NOT ANSWER"));
  CHECK_THAT(r.body, Contains("\"off\":false"));
  wait_until("the state to say so", [&] { return s.state().at("link").at("answers") == false; });
  CHECK(s.state().at("status").is_null());
}

TEST_CASE("STOP: another rig in the place of the one that fires confirms nothing", "[serve]") {
  auto first = std::make_unique<rigs::LocalRig>(rigs::SimRigConfig{}, sim::Specimen{});
  const std::string address = first->address();
  Served s(served_plan, "ip:" + address);
  s.bench.run(scene_of("angles_deg = [0, 45, 90, 135]\nrepeats = 500\n"));
  wait_until("the first shot", [&] { return s.shots() > 0; });
  first.reset();
  rigs::IiodServer second(rigs::SimRigConfig{}, sim::Specimen{}, address);
  std::thread serving([&] { second.serve(); });
  const host::StopAnswer stopped = s.bench.stop();
  second.stop();
  serving.join();
  CHECK_FALSE(stopped.off);
  CHECK_THAT(stopped.text, Contains("in the place of"));
}
