#include <catch2/catch.hpp>
#include <future>
#include <stdexcept>

#include "host/serve/ahead.h"
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
        simulated.push_back(shot);
      }
    return simulated.dump();
  };
  const std::string beside = fired({});
  CHECK(fired({90}) == beside);
  CHECK(fired({30, 45}) == beside);
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
  CHECK(s.get("/api/campaigns").at(0).at("resumable") == true);
  REQUIRE(s.ask("POST", "/api/campaigns/1/resume", "{}").status == 202);
  CHECK(s.state().at("job").at("done").get<std::size_t>() >= before);
  s.until_ended();
  CHECK(s.get("/api/campaigns").size() == 1);
  CHECK(s.shots() == 6);
  CHECK(s.get("/api/campaigns").at(0).at("resumable") == false);
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
