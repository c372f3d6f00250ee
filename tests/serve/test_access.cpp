#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/places.h"
#include "tests/serve/served.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

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

TEST_CASE("live bench: behind a proxy with TLS the page opens encrypted WebSockets", "[serve]") {
  // others are mixed content on a page that came encrypted: a browser may refuse them
  int plain = 0, encrypted = 0;
  for (const auto& file : std::filesystem::directory_iterator(source_dir() + "/host/serve/page")) {
    const std::string text = read_file(file.path().string());
    for (std::size_t at = 0; (at = text.find("'ws://'", at)) != std::string::npos; ++at) ++plain;
    const std::string both = "location.protocol === 'https:' ? 'wss://' : 'ws://'";
    for (std::size_t at = 0; (at = text.find(both, at)) != std::string::npos; ++at) ++encrypted;
  }
  CHECK(encrypted == 1);
  CHECK(plain == encrypted);
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
