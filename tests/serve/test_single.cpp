#include <atomic>
#include <catch2/catch.hpp>
#include <future>
#include <stdexcept>
#include <thread>

#include "host/gather/scene.h"
#include "host/serve/ahead.h"
#include "host/serve/documents.h"
#include "host/serve/later.h"
#include "tests/serve/served.h"

/// Single closings and the simulation made before they are fired.

using namespace powbench;
using namespace powbench::test;
using nlohmann::json;

TEST_CASE("live bench: of several closings that may come next the newest is simulated, once", "[serve]") {
  host::Ahead ahead;
  const auto key = [](double angle) { return host::Ahead::Key{"plan", "specimen", angle, 1}; };
  std::promise<void> begun, go_on;
  int made = 0;
  const auto closing = [&](int evaluations) {
    ++made;
    host::Ahead::Closing c;
    c.simulated.evaluations = evaluations;
    return c;
  };
  ahead.want(key(1), [&] {
    begun.set_value();
    go_on.get_future().wait();
    return closing(1);
  });
  begun.get_future().wait();
  ahead.want(key(2), [&] { return closing(2); });
  ahead.want(key(3), [&] { return closing(3); });
  CHECK(ahead.ready(key(1)) == nullptr);
  CHECK(ahead.wait(key(2)) == nullptr);  // nobody wants it any more
  go_on.set_value();
  CHECK(ahead.wait(key(3))->simulated.evaluations == 3);
  CHECK(ahead.ready(key(3))->simulated.evaluations == 3);
  ahead.want(key(3), [&] { return closing(4); });  // it is there
  CHECK(ahead.wait(key(3))->simulated.evaluations == 3);
  CHECK(made == 2);
  ahead.want(key(5), []() -> host::Ahead::Closing { throw std::runtime_error("no such closing"); });
  CHECK_THROWS_WITH(ahead.wait(key(5)), "no such closing");
}

TEST_CASE("live bench: a simulation made ahead is the one made beside the shot, bit for bit", "[serve]") {
  const auto fired = [](const std::vector<double>& prepared) {
    const Served s;
    for (const double angle : prepared)
      CHECK(s.ask("POST", "/api/prepare", json{{"angle_deg", angle}}.dump()).status == 202);
    CHECK(s.shots() == 0);
    for (const char* angle : {"90", "90", "30"}) {
      REQUIRE(s.ask("POST", "/api/fire", std::string("{\"angle_deg\": ") + angle + "}").status == 202);
      s.until_ended();
    }
    json all = s.get("/api/campaigns/1/shots").at("shots");
    CHECK(all.size() == 5);  // an angle is simulated once
    json simulated = json::array();
    for (json& shot : all)
      if (shot.at("kind") == "simulated") {
        shot.erase("started");
        // its U comes later, and from what the shot really had
        for (auto& [symbol, q] : shot.at("quantities").items()) q.erase("u");
        simulated.push_back(shot);
      }
    return simulated.dump();
  };
  const std::string beside = fired({});
  CHECK(fired({90}) == beside);
  CHECK(fired({30, 45}) == beside);
}

TEST_CASE("live bench: a fault is ended by whoever has read it, and nothing is fired before", "[serve]") {
  const Served s;
  const auto post = [&](const char* path, const json& body) { return s.ask("POST", path, body.dump()); };
  const auto state = [&] { return s.get("/api/bench").at("status").at("state"); };
  wait_until("the first look", [&] { return !s.get("/api/bench").at("status").is_null(); });
  CHECK(post("/api/acknowledge", {{"fault", 1}}).status == 200);  // there is none
  REQUIRE(post("/api/conditions", {{"supply_volts", 20}}).status == 200);
  REQUIRE(post("/api/fire", {{"angle_deg", 90}}).status == 202);
  s.until_ended();
  wait_until("the look at the fault", [&] { return state() == "fault"; });
  const json status = s.get("/api/bench").at("status");
  CHECK(status.at("fault") == "1 mains_lost");
  CHECK(status.at("last_error") == "mains lost: check the supply, then acknowledge the fault");
  REQUIRE(post("/api/conditions", {{"supply_volts", 230}}).status == 200);
  CHECK(post("/api/stop", json::object()).status ==
        200);  // the coil is off, and the fault is still to be read
  CHECK(state() == "fault");
  const auto refused = post("/api/fire", {{"angle_deg", 90}});
  CHECK(refused.status == 409);
  CHECK(refused.body.find("the rig is in fault, 1 mains_lost") != std::string::npos);
  CHECK(post("/api/acknowledge", {{"fault", 3}}).status == 409);  // another one than was read
  CHECK(state() == "fault");
  CHECK(post("/api/acknowledge", {{"fault", 1}}).status == 200);
  CHECK(state() != "fault");
  REQUIRE(post("/api/fire", {{"angle_deg", 90}}).status == 202);
  CHECK(post("/api/acknowledge", {{"fault", 1}}).status == 409);  // a job is on
  s.until_ended();
  CHECK(s.get("/api/campaigns/2/shots").at("shots").at(0).at("outcome") == "NOT JUDGED");
}

TEST_CASE("live bench: a plan that was ended is gone on with, where its rig and specimen are", "[serve]") {
  const Served s;
  const std::string plan = "name = \"long\"\nangles_deg = [0, 60]\nrepeats = 3\npause_s = 0.2\n";
  REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", plan}}.dump()).status == 202);
  wait_until("the first shot", [&] { return s.shots() > 0; });
  s.ask("POST", "/api/plan/end", "{}");
  s.until_ended();
  const std::size_t before = s.shots();
  REQUIRE(before < 6);
  // the log is read by a person who has a page, not a command line
  const std::string log = s.state().at("log").dump();
  CHECK_THAT(log, Catch::Contains("the button 'Fire the rest' on the page Documents"));
  CHECK_THAT(log, !Catch::Contains("--resume"));
  CHECK(s.get("/api/campaigns").at(0).at("resumable") == true);
  std::size_t missing = 0;
  const json unfinished = s.get("/api/campaigns").at(0);
  for (const json& m : unfinished.at("missing")) missing += m.at("shots").get<std::size_t>();
  CHECK(missing == 6 - before);
  REQUIRE(s.ask("POST", "/api/campaigns/1/resume", "{}").status == 202);
  CHECK(s.state().at("job").at("done").get<std::size_t>() >= before);
  s.until_ended();
  CHECK(s.get("/api/campaigns").size() == 1);
  CHECK(s.shots() == 6);
  CHECK(s.get("/api/campaigns").at(0).at("resumable") == false);
  CHECK(s.get("/api/campaigns").at(0).at("missing").empty());
  const auto refused = [&](const char* path, int status, const char* why) {
    const host::Reply r = s.ask("POST", path, "{}");
    CHECK(r.status == status);
    CHECK_THAT(r.body, Catch::Contains(why));
  };
  refused("/api/campaigns/1/resume", 409, "campaign 1 is finished");
  refused("/api/campaigns/9/resume", 404, "no campaign 9");
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  refused("/api/campaigns/2/resume", 409, "of single closings");
  host::Store store(s.folder.file("lab.db"));
  host::CampaignInfo c = store.campaign(1);
  c.rig_identity = "another bench, 7";
  store.create_campaign(c);
  refused("/api/campaigns/3/resume", 409, "was begun on 'another bench, 7'");
  c.specimen_hash = "0";
  store.create_campaign(c);
  refused("/api/campaigns/4/resume", 409, "another specimen file");
  CHECK(s.state().at("job").is_null());
}

TEST_CASE(
    "live bench: a simulation without its U is not judged; a single closing's U comes after its picture",
    "[serve]") {
  const Served s;
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  wait_until("the prediction", [&] { return !s.state().at("newest_prediction").is_null(); });
  host::Store store(s.folder.file("lab.db"));
  const auto shots = store.shots(1);
  REQUIRE(shots.size() == 2);
  // the same two closings where nobody has told the simulation's U
  const std::int64_t other = store.create_campaign(store.campaign(1));
  for (host::StoredShot shot : shots) {
    const Record record = store.load_record(shot.id);
    const auto events = store.load_events(shot.id);
    shot.campaign = other;
    store.store_shot(shot, &record, &*events,
                     host::extraction_info(host::run_options(scene_of(served_plan).plan)));
  }
  const auto touch = [&](std::int64_t campaign) {
    for (const host::StoredShot& shot : store.shots(campaign, host::ShotKind::measured)) {
      const json document = json::parse(host::shot_document(store, shot));
      for (const json& q : document.at("quantities"))
        if (q.at("symbol") == "t_ct1") return q;
    }
    return json();
  };
  const json with = touch(1), without = touch(other);
  CHECK(with.at("simulated_u").get<double>() >
        10e-6);  // what the coil's temperature and the voltage's scale leave open
  CHECK(with.at("over_U").is_number());
  CHECK(with.at("agreement") == "agrees");
  // with the U comes what the closing's own conditions add
  const double asked = without.at("simulated").get<double>(), reached = with.at("simulated").get<double>();
  CHECK(reached == asked + store.prediction(shots[1].id).moved.at(shots[0].number).at("t_ct1"));
  CHECK(std::fabs(reached - asked) < 3 * with.at("simulated_u").get<double>());
  CHECK(without.at("simulated_u").is_null());
  CHECK(without.at("over_U").is_null());
  CHECK(without.at("agreement") == "no simulated U yet");
}

TEST_CASE("live bench: a task for later gives up when the bench ends", "[serve]") {
  bool gave_up = false;
  {
    host::Later later;
    std::promise<void> begun;
    later.add([&] {
      begun.set_value();
      while (!later.ending()) std::this_thread::yield();
      gave_up = true;
    });
    begun.get_future().wait();
  }
  CHECK(gave_up);
}

TEST_CASE("live bench: of more tasks for later than are kept the oldest are dropped", "[serve]") {
  std::vector<std::size_t> done;
  {
    host::Later later;
    std::promise<void> begun, go_on, all;
    later.add([&] {
      begun.set_value();
      go_on.get_future().wait();
    });
    begun.get_future().wait();
    for (std::size_t i = 0; i < host::Later::most_waiting + 10; ++i)
      later.add([&done, i] { done.push_back(i); });
    go_on.set_value();
    later.add([&] { all.set_value(); });
    all.get_future().wait();
  }
  REQUIRE(!done.empty());
  CHECK(done.front() >= 10);
  CHECK(done.back() == host::Later::most_waiting + 9);
}

namespace {

/// Stands still but for what is slept, and what a test adds.
class StandingClock final : public Clock {
 public:
  double now() const override { return time_; }
  void sleep(double seconds) override { add(seconds); }
  void add(double seconds) {
    for (double t = time_; !time_.compare_exchange_weak(t, t + seconds);) {
    }
  }

 private:
  std::atomic<double> time_ = 0;
};

}  // namespace

TEST_CASE("live bench: the time left is told from the time that firing took, not from a pause", "[serve]") {
  const Folder folder;
  StandingClock clock;  // firing takes no time, the pause between two shots 2 s
  host::Bench bench(
      "sim:", scene_of(served_plan), folder.file("lab.db"), [] {}, [] {}, clock);
  const auto job = [&] { return json::parse(bench.state()).at("job"); };
  bench.run(scene_of("angles_deg = [0]\nrepeats = 500\npause_s = 2\n"));
  double waited = 0;
  for (int round = 0; round < 3; ++round) {
    wait_until("some shots", [&] { return job().at("done") > 2 * round + 1; });
    bench.pause(true);
    CHECK(job().at("seconds_left").is_null());
    wait_until("the pause", [&] { return job().at("doing") == "paused"; });
    const int done = job().at("done").get<int>();
    REQUIRE(done < 400);
    CHECK(clock.now() - waited == Approx(2 * done));
    clock.add(1000);
    waited += 1000;
    bench.pause(false);
    wait_until("a shot after the pause", [&] { return job().at("done") > done; });
    const json now = job();
    const double left = now.at("seconds_left").get<double>(), shots = 500 - now.at("done").get<int>();
    // of the pause behind the shot just stored anything may have passed
    CHECK(left <= 2 * shots + 1e-6);
    CHECK(left >= 2 * (shots - 1) - 1e-6);
  }
  bench.end();
  wait_until("the end", [&] { return job().is_null(); });
}

TEST_CASE("live bench: a pause of the plan is no firing, and is in the time left from the first shot on",
          "[serve]") {
  const Served s;
  const std::string plan = "angles_deg = [0, 90]\nrepeats = 1\npause_s = 2.5\n";
  REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", plan}}.dump()).status == 202);
  json job;
  wait_until("the pause", [&] {
    job = s.state().at("job");
    return job.is_object() && job.at("doing").get<std::string>().starts_with("cooling");
  });
  CHECK_THAT(job.at("doing").get<std::string>(), Contains("cooling, next shot in ") && Contains(" s"));
  CHECK(job.at("done") == 1);
  CHECK(job.at("seconds_left").get<double>() > 0);
  CHECK(s.get("/api/bench").at("status").at("gate") == false);
  wait_until("the second shot", [&] {
    const json now = s.state().at("job");
    return now.is_null() || now.at("done") == 2;
  });
  const json now = s.state().at("job");  // behind the last shot there is nothing to cool for
  CHECK((now.is_null() || now.at("doing") != "cooling, next shot in 3 s"));
  s.until_ended();
}

TEST_CASE("live bench: a plan ends at a latched fault, and says how many shots have a record", "[serve]") {
  const Served s;
  const std::string plan = "name = \"low\"\nangles_deg = [0, 90, 180]\nrepeats = 2\nsupply_volts = 20\n";
  REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", plan}}.dump()).status == 202);
  s.until_ended();
  wait_until("the next look", [&] { return s.state().at("status").at("state") == "fault"; });
  const json now = s.state();
  CHECK(now.at("ended").at("done") == 0);
  CHECK(now.at("ended").at("shots") == 6);
  CHECK_THAT(now.at("ended").at("why").get<std::string>(),
             Contains("stopped because the rig is in fault; mend the cause and acknowledge the fault"));
  const json campaign = s.get("/api/campaigns").at(0);
  CHECK(campaign.at("outcomes").at("ERROR") == campaign.at("shots"));
  CHECK(campaign.at("shots") < 3);
  CHECK(campaign.at("resumable") == true);
}

TEST_CASE("live bench: while the gate is on the state says so, and what would stand in the way of a shot",
          "[serve]") {
  const Served s;
  wait_until("the rig", [&] { return !s.state().at("status").is_null(); });
  json status = s.state().at("status");
  CHECK(status.at("gate") == false);
  CHECK(status.at("relay") == false);
  CHECK(status.at("ready") == "yes");
  REQUIRE(s.ask("POST", "/api/conditions", R"({"hold_time_ms": 10000})").status == 200);
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  wait_until("the coil", [&] {
    const json now = s.state();
    status = now.at("status");
    return status.at("gate") == true || now.at("job").is_null();
  });
  CHECK(status.at("gate") == true);
  CHECK(status.at("relay") == true);
  CHECK_THAT(status.at("ready").get<std::string>(), Contains("cannot arm while"));
  s.until_ended();
  const json list = s.get("/api/rig/interlocks");
  REQUIRE(list.size() == 22);
  CHECK(list[11].at("name") == "emergency_stop");
  CHECK(list[0].at("limit") == "20 ms");
}

TEST_CASE("live bench: voltage and hold time of single closings are changed within their range", "[serve]") {
  const Served s;
  const auto set = [&](const std::string& body) { return s.ask("POST", "/api/conditions", body); };
  REQUIRE(set(R"({"hold_time_ms": 60})").status == 200);
  CHECK(s.state().at("plan").at("hold_time_ms") == Approx(60));
  CHECK(s.state().at("plan").at("supply_volts") == 230);
  CHECK(s.state().at("plan").at("usual").at("hold_time_ms") == Approx(100));
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  CHECK(s.get("/api/shots/1").at("hold_time_s") == Approx(0.06));
  const host::Reply wrong = set(R"({"hold_time_ms": 20000})");
  CHECK(wrong.status == 422);
  CHECK_THAT(wrong.body, Contains("hold_time_ms") && Contains("1..10000"));
  CHECK(s.state().at("plan").at("hold_time_ms") == Approx(60));
  CHECK(set(R"({"angle_deg": 60})").status == 400);
}

TEST_CASE("live bench: a list of numbers gets its brackets", "[serve]") {
  const Served s;
  const auto set = [&](const char* key, const char* value) {
    const json body{
        {"text", "angles_deg = [0]\nrepeats = 1\n"}, {"section", ""}, {"key", key}, {"value", value}};
    return json::parse(s.ask("POST", "/api/files/plan/set", body.dump()).body).at("text").get<std::string>();
  };
  CHECK(set("angles_deg", "0, 45, 90") == "angles_deg = [0, 45, 90]\nrepeats = 1\n");
  CHECK(set("angles_deg", "[0, 45]") == "angles_deg = [0, 45]\nrepeats = 1\n");
  CHECK(set("repeats", "3") == "angles_deg = [0]\nrepeats = 3\n");
}
