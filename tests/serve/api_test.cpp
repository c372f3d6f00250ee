#include <catch2/catch.hpp>

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

TEST_CASE("live bench: a plan is checked, run, held, ended", "[serve]") {
  const Served s;
  const json checked = json::parse(s.ask("POST", "/api/plan/check", json{{"text", served_plan}}.dump()).body);
  CHECK(checked.at("shots").size() == 3);
  CHECK(checked.at("seconds").get<double>() > 0);

  const host::Reply wrong = s.ask(
      "POST", "/api/plan/check", json{{"text", "angels_deg = [1]\nrepeats = 0\nsupply_volts = -3\n"}}.dump());
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
  CHECK(s.ask("POST", "/api/plan/hold", R"({"on": true})").status == 200);
  CHECK(s.state().at("job").at("held") == true);
  CHECK(s.ask("POST", "/api/plan/end", "{}").status == 200);
  s.until_ended();
  CHECK(s.shots() < 3 + 400);
  CHECK(s.ask("POST", "/api/plan/end", "{}").status == 409);
  CHECK(s.ask("POST", "/api/plan/hold", R"({"on": true})").status == 409);
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
  CHECK(a.right("0123456789abcdef") == host::Right::fire);
  CHECK(a.right("fedcba9876543210") == host::Right::read);
  CHECK(a.right("") == host::Right::none);
  CHECK(a.right("0123456789abcdeF") == host::Right::none);
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
      {"POST", "/api/fire", R"({"angle_deg": "90"})", 400, "angle_deg"},
      {"POST", "/api/fire", R"({"angle_deg": 360})", 400, "outside 0 to 359.99"},
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
  const json api = s.get("/api");
  CHECK(api.at("openapi") == "3.0.3");
  CHECK(api.at("paths").size() >= 15);
  for (const auto& [path, methods] : api.at("paths").items())
    for (const auto& [method, operation] : methods.items()) {
      CAPTURE(path, method);
      std::string name = method, place = path;
      for (char& c : name) c = static_cast<char>(std::toupper(c));
      if (const auto hole = place.find("{id}"); hole != std::string::npos) place.replace(hole, 4, "12345");
      if (place == "/api/plan/check")
        CHECK(s.ask("POST", place,
                    operation.at("requestBody").at("content").at("application/json").at("example").dump())
                  .status == 200);
      const host::Reply r = s.ask(name, place, operation.contains("requestBody") ? "{}" : "");
      CHECK(r.status != 405);
      CHECK(r.body.find("nothing at this address") == std::string::npos);
      // without a token only what the description says
      host::Request bare;
      bare.method = name;
      bare.path = place;
      bare.host = here;
      const bool open = operation.at("security").empty();
      if (open) CHECK(s.api.answer(bare).status == 200);
    }
  s.until_ended();
}
