#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "tests/serve/served.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

TEST_CASE("live bench: a closing is fired, stored, compared and drawn", "[serve]") {
  const Served s;
  CHECK(s.state().at("rig").at("origin") == "SIMULATED RIG");
  CHECK(s.state().at("newest_shot").is_null());
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  const auto id = s.state().at("newest_shot").get<int>();
  const json shot = s.get("/api/shots/" + std::to_string(id));
  CHECK(shot.at("angle_deg") == 90.0);
  CHECK(shot.at("origin") == "SIMULATED RIG");
  for (const auto& q : shot.at("quantities"))
    if (q.at("symbol") == "t_ct1") {
      CHECK(q.at("value").get<double>() > 5e-3);
      CHECK(q.at("u").get<double>() > 0);
      CHECK(q.at("simulated").get<double>() == Approx(q.at("value").get<double>()).margin(1e-4));
    }
  const json closing = s.get("/api/shots/" + std::to_string(id) + "/closing");
  REQUIRE(closing.size() == 1);
  CHECK(closing.at(0).at("channels").size() == 6);
  CHECK(s.ask("GET", "/api/shots/" + std::to_string(id) + "/waveforms.csv").body.size() > 100'000);
  CHECK_THAT(s.ask("GET", "/api/campaigns/1/report.html").body, Contains("SIMULATED RIG"));

  // another one goes to the same campaign
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 30})").status == 202);
  s.until_ended();
  CHECK(s.get("/api/campaigns").size() == 1);
  CHECK(s.shots() == 2);
}

TEST_CASE("live bench: a plan is checked, run, paused, ended", "[serve]") {
  const Served s;
  const json checked =
      json::parse(s.ask("POST", "/api/files/plan/check", json{{"text", served_plan}}.dump()).body);
  CHECK(checked.at("fired").at("shots").size() == 3);
  CHECK(checked.at("fired").at("seconds").get<double>() > 0);

  const host::Reply wrong =
      s.ask("POST", "/api/files/plan/check",
            json{{"text", "angels_deg = [1]\nrepeats = 0\nsupply_volts = -3\n"}}.dump());
  CHECK(wrong.status == 200);  // mistakes are what was asked for
  CHECK(s.ask("POST", "/api/plan/run", json{{"text", "repeats = 0\n"}}.dump()).status == 422);
  const json errors = json::parse(wrong.body).at("errors");
  CHECK(errors.size() >= 3);
  CHECK_THAT(errors.at(0).get<std::string>(), Contains("angles_deg"));

  REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", served_plan}}.dump()).status == 202);
  s.until_ended();
  CHECK(s.shots() == 3);
  CHECK(s.get("/api/campaigns/1/shots").at("shots").size() == 6);  // three measured, three simulated

  const std::string longer = "name = \"long\"\nangles_deg = [0, 30, 60, 90]\nrepeats = 100\npause_s = 0.05\n";
  REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", longer}}.dump()).status == 202);
  CHECK(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 409);
  CHECK(s.ask("POST", "/api/plan/run", json{{"text", longer}}.dump()).status == 409);
  CHECK(s.ask("POST", "/api/plan/pause", R"({"on": true})").status == 200);
  CHECK(s.state().at("job").at("paused") == true);
  CHECK(s.ask("POST", "/api/plan/end", "{}").status == 200);
  s.until_ended();
  CHECK(s.shots() < 3 + 400);
  CHECK(s.ask("POST", "/api/plan/end", "{}").status == 409);
  CHECK(s.ask("POST", "/api/plan/pause", R"({"on": true})").status == 409);
}

TEST_CASE("live bench: closing at touch", "[serve]") {
  const Served s;
  for (const double wanted : {0.0, 90.0, 200.0}) {
    CAPTURE(wanted);
    REQUIRE(s.ask("POST", "/api/fire", json{{"touch_deg", wanted}}.dump()).status == 202);
    s.until_ended();
    const json shot = s.get("/api/shots/" + s.state().at("newest_shot").dump());
    const double reached = shot.at("touch_rad").at("value").get<double>() * 180 / pi;
    // of the rig: angle within its tolerance of 1 deg, which the closing may multiply; noise of touch below 0.3 ms =
    // 5 deg
    CHECK(std::fabs(std::remainder(reached - wanted, 360)) < 6);
    CHECK(s.state().at("newest_aim_deg") == Approx(wanted));
  }
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  CHECK(s.state().at("newest_aim_deg").is_null());
  CHECK(s.get("/api/campaigns").at(0).at("name") == "single closings");  // its plan was never run
  CHECK(s.ask("POST", "/api/fire", R"({"touch_deg": 90, "angle_deg": 90})").status == 400);
  CHECK(s.ask("POST", "/api/fire", R"({"touch_deg": 361})").status == 400);
}

TEST_CASE("live bench: the mains at the touch, behind a coil switch that takes its time", "[serve]") {
  const Folder rigs;
  const std::string rig =
      rigs.write("relay.rig.toml",
                 "[switch]\nkind = \"relay\"\nclosing_delay_ms = 4\n[electrical]\ncontact_open_V = 2\n");
  const Served s(served_plan, "sim:" + rig);
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  const std::string path = "/api/shots/" + s.state().at("newest_shot").dump();
  const json shot = s.get(path);
  const auto degrees_of = [&](const char* key) { return shot.at(key).at("value").get<double>() * 180 / pi; };
  CHECK(std::fabs(std::remainder(degrees_of("reached_rad") - 90 - 4e-3 * 50 * 360, 360)) < 3);
  for (const auto& q : shot.at("quantities"))
    if (q.at("symbol") == "t_ct1") {
      // the mains stood at 90 deg at the gate edge, from which the touch counts
      const double at_touch = 90 + q.at("value").get<double>() * 50 * 360;
      CHECK(std::fabs(std::remainder(degrees_of("touch_rad") - at_touch, 360)) < 3);
    }
  // open and closed in the picture of the device: by the level of the extraction
  const json closing = s.get(path + "/closing");
  REQUIRE(closing.size() == 1);
  REQUIRE(closing.at(0).at("contact_level_V").is_number());
  CHECK(closing.at(0).at("contact_level_V").get<double>() == Approx(1).margin(0.05));
}

TEST_CASE("live bench: the page says of U what the report says, and of the films what was done", "[serve]") {
  const Served s;
  REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", served_plan}}.dump()).status == 202);
  s.until_ended();
  const std::string page = s.ask("GET", "/").body;
  for (const std::string& text : {page, s.ask("GET", "/api/campaigns/1/report.html").body}) {
    CHECK_THAT(text, Contains("neither the scale of a channel nor what another supply voltage or coil "
                              "temperature would change"));
    CHECK_THAT(text, Contains("offset, hum, droop, and all above"));
    CHECK_THAT(text, !Contains("vibration that was") && !Contains("stripped off"));
  }
  CHECK_THAT(page, !Contains("lies within"));
}

TEST_CASE("live bench: a record as the scope gets it is the record", "[serve]") {
  const Served s;
  CHECK(s.bench.frame() == nullptr);
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  const std::string frame = *s.bench.frame();
  CHECK(frame == s.ask("GET", "/api/shots/1/record").body);
  const auto byte = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(frame[i]));
  };
  const std::size_t head = byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
  const json what = json::parse(frame.substr(4, head));
  const host::Store store(s.folder.file("lab.db"), host::Store::Mode::read_only);
  const Record record = store.load_record(1);
  REQUIRE(what.at("samples") == record.samples());
  REQUIRE(frame.size() == 4 + head + 2 * record.samples() * record.channels.size());
  for (std::size_t c = 0; c < record.channels.size(); ++c)
    for (std::size_t i = 0; i < record.samples(); i += 97) {
      const std::size_t at = 4 + head + 2 * (c * record.samples() + i);
      REQUIRE(static_cast<std::int16_t>(byte(at) | byte(at + 1) << 8) == record.channels[c].raw[i]);
    }
}

TEST_CASE("live bench: files are stored where the bench was started from, and nowhere else", "[serve]") {
  const Folder folder;
  const std::string specimen = folder.write("one.specimen.toml", "name = \"one\"\n"),
                    plan = folder.write("lab.plan.toml",
                                        "specimen = \"one.specimen.toml\"\nangles_deg = [0]\nrepeats = 1\n"),
                    rig = folder.write("one.rig.toml", "# ours\n");
  host::Bench bench("sim:" + rig, host::load_scene(plan), folder.file("lab.db"), [] {});
  const host::Api api(bench, host::Access::made({here}), plan);
  const auto ask = [&](const std::string& path, const json& body, bool token = true) {
    host::Request r;
    r.method = body.is_null() ? "GET" : "POST";
    r.path = path;
    r.body = body.is_null() ? "" : body.dump();
    r.host = here;
    r.content_type = "application/json";
    if (token) r.token = api.access().page_token();
    return api.answer(r);
  };
  CHECK(json::parse(ask("/api/files/plan", nullptr).body).at("file") == "lab.plan.toml");
  CHECK_THAT(json::parse(ask("/api/files/rig", nullptr).body).at("text").get<std::string>(),
             Contains("# ours"));
  const std::string better = "specimen = \"one.specimen.toml\"\nangles_deg = [0, 30]\nrepeats = 2\n";
  CHECK(ask("/api/files/plan/save", {{"text", better}}, false).status == 401);
  CHECK(ask("/api/files/plan/save", {{"text", "repeats = 2\n"}}).status == 422);
  CHECK(ask("/api/files/plan/save", {{"text", better + "specimen = \"/etc/passwd\"\n"}}).status == 422);
  CHECK(read_file(plan).find("30") == std::string::npos);
  REQUIRE(ask("/api/files/plan/save", {{"text", better}}).status == 200);
  CHECK(read_file(plan) == better);
  CHECK(bench.scene().shots.size() == 4);
  REQUIRE(ask("/api/files/specimen/save", {{"text", "name = \"two\"\n"}}).status == 200);
  CHECK(bench.scene().specimen.name == "two");
  REQUIRE(ask("/api/files/rig/save", {{"text", "# theirs\n"}}).status == 200);
  CHECK(read_file(rig) == "# theirs\n");
  const json set = json::parse(
      ask("/api/files/specimen/set",
          {{"text", "name = \"two\"\n"}, {"section", "bridges"}, {"key", "gap_mm"}, {"value", "2.6"}})
          .body);
  CHECK(set.at("text") == "name = \"two\"\n\n[bridges]\ngap_mm = 2.6\n");
  CHECK(ask("/api/files/specimen/set", {{"text", ""}, {"section", "x"}, {"key", "y\nz"}, {"value", "1"}})
            .status == 404);
  // without files there is nowhere to write
  const Served none;
  CHECK(none.ask("POST", "/api/files/plan/save", json{{"text", served_plan}}.dump()).status == 409);
  CHECK(none.ask("POST", "/api/files/rig/save", json{{"text", ""}}.dump()).status == 409);
}

TEST_CASE("live bench: two campaigns compared, only newer shots, what to take along", "[serve]") {
  const Served s;
  for (int i = 0; i < 2; ++i) {
    REQUIRE(s.ask("POST", "/api/plan/run", json{{"text", served_plan}}.dump()).status == 202);
    s.until_ended();
  }
  const auto query = [&](const std::string& path, const std::string& q) {
    host::Request r;
    r.method = "GET";
    r.path = path;
    r.query = q;
    r.host = here;
    return s.api.answer(r);
  };
  const json pair = json::parse(query("/api/compare", "first=1&second=2").body);
  CHECK(pair.at("rows").size() == 3 * quantity_table.size());
  CHECK(pair.at("second").at("id") == 2);
  CHECK(query("/api/compare", "first=1&second=3").status == 404);
  for (const auto& [wrong, why] :
       {std::pair{"", "'first' is missing: a campaign's number, as in /api/compare?first=1&second=2"},
        {"first=1", "'second' is missing"},
        {"first=1&second=1", "'first' and 'second' are the same campaign: there is nothing to compare"},
        {"first=a", "'first=a' in the address: a whole number is wanted, as in first=1"},
        {"first=1&second=x", "'second=x' in the address: a whole number is wanted"}}) {
    CHECK(query("/api/compare", wrong).status == 400);
    CHECK_THAT(query("/api/compare", wrong).body, Contains(why));
  }
  // a simulated value has the u of its inputs, not of the reading of its curve; a measured one beside it says whether
  // they agree
  const json shots =
      s.get("/api/campaigns/1/shots");  // a range of a temporary would not outlive its first line
  for (const json& shot : shots.at("shots")) {
    const json touch = shot.at("quantities").at("t_ct1");
    const host::Store store(s.folder.file("lab.db"), host::Store::Mode::read_only);
    const auto id = shot.at("id").get<std::int64_t>();
    if (shot.at("kind") == "simulated")
      CHECK(touch.at("u").get<double>() == Approx(store.prediction(id).u.at("t_ct1")));
    else {
      const json detail = s.get("/api/shots/" + std::to_string(id));
      for (const json& q : detail.at("quantities")) {
        if (q.at("over_U").is_null()) continue;
        const double U = 2 * std::hypot(q.at("u").get<double>(), q.at("simulated_u").get<double>());
        const double over = std::fabs(q.at("value").get<double>() - q.at("simulated").get<double>()) / U;
        CHECK(q.at("over_U").get<double>() == Approx(over).epsilon(0.02));
        CHECK(q.at("agreement") == (q.at("over_U").get<double>() <= 1 ? "agrees" : "differs"));
      }
    }
  }
  const json all = s.get("/api/campaigns/1/shots").at("shots");
  const auto after = all.at(2).at("id").get<int>();
  CHECK(json::parse(query("/api/campaigns/1/shots", "after=" + std::to_string(after)).body)
            .at("shots")
            .size() == all.size() - 3);
  const host::Store store(s.folder.file("lab.db"), host::Store::Mode::read_only);
  for (std::int64_t last = 0; last <= 13; ++last)
    for (const std::int64_t campaign : {1, 2, 3}) {
      std::set<std::int64_t> wanted, got;
      for (const auto& shot : store.shots(campaign))
        if (shot.id > last) wanted.insert(shot.id);
      for (const auto& shot : store.shots_after(campaign, last)) got.insert(shot.id);
      CHECK(got == wanted);
    }
  const json campaigns = s.get("/api/campaigns");
  CHECK(campaigns.at(0).at("angles_deg").size() == 3);
  CHECK(campaigns.at(0).at("outcomes").at("NOT JUDGED") == 3);
  const std::string table = s.ask("GET", "/api/campaigns/1/shots.csv").body;
  CHECK_THAT(table, Contains("# SIMULATED RIG, campaign 1") && Contains("t_ct1_s,u_t_ct1") &&
                        Contains("standard uncertainty"));
  CHECK(std::count(table.begin(), table.end(), '\n') ==
        static_cast<std::ptrdiff_t>(2 + quantity_table.size() + 6));
  CHECK_THAT(table, Contains("# t_ct1: "));
  CHECK_THAT(s.ask("GET", "/api/campaigns/1/junit.xml").body, Contains("<testsuite"));
  CHECK(s.get("/api/shots/1/events.json").at("origin") == "SIMULATED RIG");
  CHECK(s.get("/api/shots/1/events.json").at("u_of_events") == "the measured event");
  CHECK(s.get("/api/rig/attributes").size() > 60);
}

TEST_CASE("live bench: additions to the test record", "[serve]") {
  const Served s;
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  CHECK(
      s.ask("POST", "/api/campaigns/1/annotations", R"({"key": "operator", "text": "operator 7"})").status ==
      201);
  CHECK(s.get("/api/campaigns/1/annotations").at(0).at("text") == "operator 7");
  CHECK_THAT(s.ask("GET", "/api/campaigns/1/report.html").body, Contains("operator 7"));
  CHECK(s.ask("POST", "/api/campaigns/1/annotations", R"({"key": "shoe size", "text": "44"})").status == 422);
  CHECK(
      s.ask("POST", "/api/campaigns/9/annotations", R"({"key": "operator", "text": "operator 7"})").status ==
      404);
}
