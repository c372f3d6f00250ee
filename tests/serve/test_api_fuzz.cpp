#include <catch2/catch.hpp>

#include "core/random.h"
#include "tests/serve/served.h"

using namespace powbench;
using namespace powbench::test;

namespace {

/// A request near to one that works, with some of it changed.
host::Request mutant(Random& random, const std::string& token) {
  static const std::vector<std::string> paths{"/",
                                              "/page.js",
                                              "/api",
                                              "/api/bench",
                                              "/api/fire",
                                              "/api/stop",
                                              "/api/prepare",
                                              "/api/acknowledge",
                                              "/api/files/plan",
                                              "/api/plan/run",
                                              "/api/files/plan/check",
                                              "/api/plan/pause",
                                              "/api/shots/1",
                                              "/api/shots/1/closing",
                                              "/api/campaigns/1/shots",
                                              "/api/campaigns/1/annotations",
                                              "/api/campaigns/1/resume",
                                              "/api/live",
                                              "/api/scope",
                                              "/api/files/plan/set",
                                              "/api/files/plan/save",
                                              "/api/files/specimen/check",
                                              "/api/files/specimen/save",
                                              "/api/files/rig/check",
                                              "/api/files/rig/save",
                                              "/api/compare",
                                              "/api/campaigns/1/shots.csv",
                                              "/api/shots/1/record"};
  static const std::vector<std::string> bodies{
      R"({"angle_deg": 90})",
      R"({"text": "angles_deg = [0]"})",
      R"({"on": true})",
      R"({"key": "remarks", "text": "x"})",
      R"({"text": "", "section": "bridges", "key": "gap_mm", "value": "1"})",
      "[[[[[[[[[[[[[[",
      ""};
  const auto pick = [&](const std::vector<std::string>& from) {
    return from[static_cast<std::size_t>(random.uniform() * static_cast<double>(from.size()))];
  };
  const auto damage = [&](std::string text) {
    const auto changes = static_cast<int>(random.uniform() * 4);
    for (int i = 0; i < changes; ++i) {
      const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size() + 1));
      const char c = static_cast<char>(random.uniform() * 256);
      if (random.uniform() < 0.3 && at < text.size())
        text.erase(at, 1);
      else if (random.uniform() < 0.5 && at < text.size())
        text[at] = c;
      else
        text.insert(at, 1, c);
    }
    return text;
  };
  host::Request r;
  r.method = random.uniform() < 0.5 ? "POST" : "GET";
  r.path = damage(pick(paths));
  r.body = damage(pick(bodies));
  r.query = random.uniform() < 0.5 ? "" : damage("first=1&second=2&after=3");
  r.host = random.uniform() < 0.95 ? here : damage(here);
  r.content_type = random.uniform() < 0.95 ? "application/json" : "text/plain";
  r.origin = random.uniform() < 0.9 ? "" : damage("http://" + here);
  r.token = damage(token);
  if (r.token == token) r.token[0] = r.token[0] == 'z' ? 'y' : 'z';  // never the right one
  return r;
}

void fuzz(int requests, std::uint64_t seed) {
  const Served s;
  Random random(seed);
  int answered = 0;
  for (int i = 0; i < requests; ++i) {
    const host::Request r = mutant(random, s.api.access().page_token());
    if (host::Api::is_stop(r) && i % 50 != 0) continue;  // each asks the rig
    const host::Reply reply = s.api.answer(r);
    if (reply.status < 200 || reply.status > 504 || reply.body.empty())
      FAIL("request " << i << " " << r.path);
    ++answered;
  }
  CHECK(answered > requests / 2);
  // without the token nothing has been fired, begun or written
  CHECK(s.shots() == 0);
  CHECK(s.get("/api/campaigns").empty());
  CHECK(s.state().at("job").is_null());
}

}  // namespace

TEST_CASE("live bench: damaged requests without the token change nothing", "[serve]") {
  fuzz(20'000, 1);
}

TEST_CASE("live bench: a million damaged requests change nothing", "[.slow]") {
  fuzz(1'000'000, 2);
}
