#pragma once

#include <nlohmann/json.hpp>

#include "host/serve/api.h"
#include "tests/folder.h"
#include "tests/waiting.h"

/// A live bench on a simulated rig, without sockets.
namespace powbench::test {

inline const std::string served_plan =
    "name = \"three angles\"\nangles_deg = [0, 60, 120]\nrepeats = 1\norder = \"sequential\"\n";
inline const std::string here = "127.0.0.1:8080";

inline host::Scene scene_of(const std::string& plan) {
  return host::make_scene(host::parse_plan(plan, "plan"));
}

struct Served {
  explicit Served(const std::string& plan = served_plan, const std::string& rig = "sim:")
      : bench(rig, scene_of(plan), folder.file("lab.db"), [] {}), api(bench, host::Access::made({here})) {}

  host::Reply ask(const std::string& method, const std::string& path, const std::string& body = {}) const {
    host::Request r;
    r.method = method;
    r.path = path;
    r.body = body;
    r.host = here;
    r.content_type = "application/json";
    r.token = api.access().page_token();
    return api.answer(r);
  }
  nlohmann::json get(const std::string& path) const { return nlohmann::json::parse(ask("GET", path).body); }
  nlohmann::json state() const { return get("/api/bench"); }
  void until_ended() const {
    wait_until("the end of the job", [&] { return state().at("job").is_null(); });
  }
  std::size_t shots() const {
    std::size_t n = 0;
    for (const auto& c : get("/api/campaigns")) n += c.at("shots").get<std::size_t>();
    return n;
  }

  Folder folder;
  host::Bench bench;
  host::Api api;
};

}  // namespace powbench::test
