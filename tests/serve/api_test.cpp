#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <regex>
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
    // of the rig: angle within its tolerance of 1 deg, which the closing may multiply; noise of touch below 0.3 ms = 5 deg
    CHECK(std::fabs(std::remainder(reached - wanted, 360)) < 6);
  }
  CHECK(s.ask("POST", "/api/fire", R"({"touch_deg": 90, "angle_deg": 90})").status == 400);
  CHECK(s.ask("POST", "/api/fire", R"({"touch_deg": 361})").status == 400);
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
  CHECK(pair.at("rows").size() == 27);
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
  // a simulated value has the u of its inputs, not of the reading of its curve; a measured one beside it says whether they agree
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
  CHECK_THAT(table, Contains("# SIMULATED RIG, campaign 1") && Contains("t_ct1_s,u_t_ct1"));
  CHECK(std::count(table.begin(), table.end(), '\n') == 2 + 6);
  CHECK_THAT(s.ask("GET", "/api/campaigns/1/junit.xml").body, Contains("<testsuite"));
  CHECK(s.get("/api/shots/1/events.json").at("origin") == "SIMULATED RIG");
  CHECK(s.get("/api/rig/attributes").size() > 60);
}

TEST_CASE("live bench: additions to the test record", "[serve]") {
  const Served s;
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  CHECK(s.ask("POST", "/api/campaigns/1/annotations", R"({"key": "operator", "text": "K. Lind"})").status ==
        201);
  CHECK(s.get("/api/campaigns/1/annotations").at(0).at("text") == "K. Lind");
  CHECK_THAT(s.ask("GET", "/api/campaigns/1/report.html").body, Contains("K. Lind"));
  CHECK(s.ask("POST", "/api/campaigns/1/annotations", R"({"key": "shoe size", "text": "44"})").status == 422);
  CHECK(s.ask("POST", "/api/campaigns/9/annotations", R"({"key": "operator", "text": "K. Lind"})").status ==
        404);
}

TEST_CASE("live bench: who may do what", "[serve]") {
  const Served s;
  host::Request r;
  r.method = "POST";
  r.path = "/api/fire";
  r.body = R"({"angle_deg": 90})";
  r.host = here;
  r.content_type = "application/json";
  const std::string good = s.api.access().page_token();

  SECTION("no token, a wrong one, one of another length") {
    for (std::string token : {std::string(), std::string(32, '0'), good + "0", good.substr(1)}) {
      r.token = token;
      CHECK(s.api.answer(r).status == 401);
    }
  }
  SECTION("the right one in the address: it reads, and fires nothing") {
    r.link_token = good;
    CHECK(s.api.answer(r).status == 401);
    r.method = "GET", r.path = "/api/access", r.body = "";
    CHECK_THAT(s.api.answer(r).body, Contains("\"may_fire\":false"));
    r.token = good;
    CHECK_THAT(s.api.answer(r).body, Contains("\"may_fire\":true"));
  }
  SECTION("a foreign name that points here") {
    r.token = good;
    for (const char* name :
         {"evil.example:8080", "127.0.0.1", "127.0.0.1:8081", "", "localhost:8080.evil.example"}) {
      r.host = name;
      CHECK(s.api.answer(r).status == 403);
    }
  }
  SECTION("a foreign page") {
    r.token = good;
    for (const char* page :
         {"http://evil.example", "null", "https://127.0.0.1:8080", "http://127.0.0.1:8081"}) {
      r.origin = page;
      CHECK(s.api.answer(r).status == 403);
      r.path = "/api/stop";
      CHECK(s.api.answer(r).status == 403);
    }
  }
  SECTION("what a form of a foreign page could send") {
    r.token = good;
    r.content_type = "text/plain";
    CHECK(s.api.answer(r).status == 415);
  }
  SECTION("stop needs nothing") {
    r.path = "/api/stop";
    r.body = r.content_type = "";
    CHECK(s.api.answer(r).status == 200);
  }
  CHECK(s.shots() == 0);
}

TEST_CASE("live bench: tokens from a file", "[serve]") {
  const Folder folder;
  const std::string file = folder.write(
      "tokens", "# the lab\nfire 0123456789abcdef\nread fedcba9876543210  # the screen in the hall\n");
  const host::Access a = host::Access::from_file(file, {here});
  CHECK(a.page_token().empty());
  const auto right = [&](const std::string& header, const std::string& address) {
    host::Request r;
    r.token = header, r.link_token = address;
    return a.right(r);
  };
  CHECK(right("0123456789abcdef", "") == host::Right::fire);
  CHECK(right("fedcba9876543210", "") == host::Right::read);
  CHECK(right("", "") == host::Right::none);
  CHECK(right("0123456789abcdeF", "") == host::Right::none);
  // an address is kept in histories and passed on: whatever its token may do elsewhere, it reads
  CHECK(right("", "0123456789abcdef") == host::Right::read);
  CHECK(right("", a.link_token()) == host::Right::read);
  CHECK(right(a.link_token(), "") == host::Right::none);
  CHECK(a.link_token().size() == 32);
  CHECK(host::Access::made({here}).link_token().empty());
  for (const auto& [text, why] : {std::pair{"fire short\n", "16 to 128"},
                                  {"shoot 0123456789abcdef\n", "a line is"},
                                  {"fire 0123456789abcdef more\n", "a line is"},
                                  {"# nothing\n", "holds no token"}})
    try {
      host::Access::from_file(folder.write("bad", text), {here});
      FAIL("accepted: " << text);
    } catch (const host::BadInput& e) {
      CHECK_THAT(e.what(), Contains(why));
    }
  CHECK_THROWS_AS(host::Access::from_file(folder.file("absent"), {here}), host::BadInput);
}

TEST_CASE("live bench: bad input is one sentence and changes nothing", "[serve]") {
  const Served s;
  const std::tuple<const char*, const char*, const char*, int, const char*> cases[] = {
      {"POST", "/api/fire", "", 400, "no JSON object"},
      {"POST", "/api/fire", "{", 400, "no JSON object"},
      {"POST", "/api/fire", "[90]", 400, "no JSON object"},
      {"POST", "/api/fire", "{}", 400, "angle_deg"},
      {"POST", "/api/fire", R"({"angle_deg": "90"})", 400, "'angle_deg' is no number"},
      {"POST", "/api/fire", R"({"angle_deg": 360.1})", 400, "outside 0 to 360"},
      {"POST", "/api/fire", R"({"angle_deg": 90, "supply_volts": 50})", 400,
       "unknown key 'supply_volts'; known: touch_deg, angle_deg"},
      {"POST", "/api/fire", R"({"angle_deg": 90, "angle_deg": 45})", 400,
       "key 'angle_deg' stands there twice"},
      {"POST", "/api/plan/run", R"({"text": "angles_deg = [0]\nrepeats = 1", "dry": true})", 400,
       "unknown key 'dry'"},
      {"POST", "/api/fire", R"({"angle_deg": -0.01})", 400, "outside"},
      {"POST", "/api/fire", R"({"angle_deg": 1e999})", 400, "no JSON object"},
      {"POST", "/api/plan/run", R"({"text": ""})", 422, "angles_deg"},
      {"POST", "/api/plan/run", R"({"text": "angles_deg = [0]\nrepeats = 1\nspecimen = \"/etc/passwd\""})",
       422, "started with"},
      {"POST", "/api/plan/run", R"({"text": "angles_deg = [0]\nrepeats = 1\nspecimen = \"../x.toml\""})", 422,
       "started with"},
      {"GET", "/api/shots/7", "", 404, "no shot 7"},
      {"GET", "/api/shots/0", "", 404, "nothing at this address"},
      {"GET", "/api/shots/-1", "", 404, "nothing at this address"},
      {"GET", "/api/shots/99999999999999999999", "", 404, "nothing at this address"},
      {"GET", "/api/shots/1/../../etc", "", 404, "nothing at this address"},
      {"GET", "/../etc/passwd", "", 404, "nothing at this address"},
      {"GET", "/api/campaigns/3/shots", "", 404, "no campaign 3"},
      {"DELETE", "/api/campaigns/1/shots", "", 405, "not for this address"},
      {"GET", "/api/fire", "", 405, "not for this address"},
  };
  for (const auto& [method, path, body, status, why] : cases) {
    CAPTURE(method, path, body);
    const host::Reply r = s.ask(method, path, body);
    CHECK(r.status == status);
    CHECK_THAT(r.body, Contains(why));
    CHECK(json::parse(r.body).is_object());
  }
  CHECK(s.shots() == 0);
  CHECK(s.state().at("job").is_null());
}

TEST_CASE("live bench: the description lists every call that answers", "[serve]") {
  const Served s;
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  const json api = s.get("/api");
  CHECK(api.at("openapi") == "3.0.3");
  CHECK(api.at("paths").size() >= 15);
  int compared = 0;
  for (const auto& [path, methods] : api.at("paths").items())
    for (const auto& [method, operation] : methods.items()) {
      CAPTURE(path, method);
      std::string name = method, place = path;
      for (char& c : name) c = static_cast<char>(std::toupper(c));
      if (const auto hole = place.find("{id}"); hole != std::string::npos)
        place.replace(hole, 4, path.ends_with(".pdf") ? "12345" : "1");  // paper takes a browser
      const bool harmless = place.ends_with("/check") || place.ends_with("/set");
      const std::string body =
          !operation.contains("requestBody") ? ""
          : harmless ? operation.at("requestBody").at("content").at("application/json").at("example").dump()
                     : "{}";
      const host::Reply r = s.ask(name, place, body);
      if (harmless) CHECK(r.status == 200);
      CHECK(r.status != 405);
      if (operation.at("responses").contains("101")) {  // tests/serve/http_test.cpp opens them
        CHECK(r.status == 426);
        const json& messages = operation.at("responses").at("101").at("content");
        if (path == std::string("/api/live"))
          CHECK(messages ==
                api.at("paths").at("/api/bench").at("get").at("responses").at("2XX").at("content"));
        continue;
      }
      // what is described is what comes, field by field
      const json& content = operation.at("responses").at("2XX").at("content");
      if (r.status < 300 && content.contains("application/json")) {
        json schema = content.at("application/json").at("schema"), got = json::parse(r.body);
        if (schema.at("type") == "array") schema = schema.at("items"), got = got.empty() ? json() : got.at(0);
        const json described = schema.value("properties", json::object());
        if (!described.empty() && got.is_object()) {
          std::vector<std::string> told, came;
          for (const auto& [key, value] : described.items()) told.push_back(key);
          for (const auto& [key, value] : got.items()) came.push_back(key);
          CHECK(told == came);
          ++compared;
        }
      }
      // without a token only what the description says
      host::Request bare;
      bare.method = name;
      bare.path = place;
      bare.host = here;
      const bool open = operation.at("security").empty();
      if (open) CHECK(s.api.answer(bare).status == 200);
    }
  CHECK(compared >= 15);
  s.until_ended();
}

TEST_CASE("live bench: the description has every address of code and page, and no other", "[serve]") {
  const Served s;
  const auto calls = s.get("/api").at("paths");
  std::set<std::string> described, in_code, in_page;
  for (const auto& [path, unused] : calls.items()) described.insert(path);
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(POWBENCH_SOURCE_DIR) / "host/serve";
  // as a row of a table or a constant has it: the text begins with it and is nothing else
  const std::regex whole("\"(/api(?:/[A-Za-z0-9_.{}/-]+)?)\"");
  for (const auto& file : fs::directory_iterator(folder)) {
    if (!file.is_regular_file() || (file.path().extension() != ".cpp" && file.path().extension() != ".h"))
      continue;
    const std::string text = read_file(file.path().string());
    for (std::sregex_iterator it(text.begin(), text.end(), whole), end; it != end; ++it)
      in_code.insert((*it)[1]);
  }
  CHECK(described == in_code);
  // what the page asks for: '/api/shots/' + id + '/closing', '/api/files/' + kind
  const std::regex part("'(/api[A-Za-z0-9_./-]*)[?']((?: \\+ [a-zA-Z.'()-]+ \\+ '([A-Za-z0-9_./-]*)')?)");
  std::size_t looked = 0;
  for (const auto& file : fs::directory_iterator(folder / "page")) {
    const std::string text = read_file(file.path().string());
    for (std::sregex_iterator it(text.begin(), text.end(), part), end; it != end; ++it) {
      const std::string begin = (*it)[1], rest = (*it)[3];
      CAPTURE(file.path().filename().string(), it->str());
      ++looked;
      const bool known = std::any_of(described.begin(), described.end(), [&](const std::string& path) {
        return begin.back() == '/' ? path.starts_with(begin) && path.ends_with(rest) && path != begin
                                   : path == begin;
      });
      CHECK(known);
    }
  }
  CHECK(looked >= 20);
}
