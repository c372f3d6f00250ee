#include <nlohmann/json.hpp>

#include "host/serve/calls.h"
#include "host/serve/http.h"
#include "rigs/interlock_list.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

Reply started() {
  return json_reply(R"({"started":true})", 202);
}

Reply get_bench(const Call& c) {
  return json_reply(c.bench.state());
}

Reply post_stop(const Call& c) {
  const StopAnswer a = c.bench.stop();
  return json_reply(Json{{"off", a.off}, {"text", a.text}, {"ms", a.ms}}.dump(-1, ' ', false,
                                                                              Json::error_handler_t::replace),
                    a.off ? 200 : 504);
}

Reply post_acknowledge(const Call& c) {
  c.bench.acknowledge(static_cast<int>(number_of(c.body, "fault", 1, 99)));
  return json_reply(R"({"acknowledged":true})");
}

Reply post_fire(const Call& c) {
  if (has(c.body, "touch_deg")) {
    if (has(c.body, "angle_deg")) throw Problem{400, "'angle_deg' and 'touch_deg' exclude each other"};
    c.bench.fire_at_touch(radians(number_of(c.body, "touch_deg", 0, 360)), c.request.received);
  } else {
    c.bench.fire(radians(number_of(c.body, "angle_deg", 0, 360)), c.request.received);
  }
  return started();
}

Reply post_prepare(const Call& c) {
  c.bench.prepare(radians(number_of(c.body, "angle_deg", 0, 360)));
  return json_reply(R"({"preparing":true})", 202);
}

Reply post_run(const Call& c) {
  c.bench.run(scene_of_body(c), c.request.received);
  return started();
}
Reply post_pause(const Call& c) {
  const bool on = flag_of(c.body, "on");
  c.bench.pause(on);
  return json_reply(Json{{"paused", on}}.dump());
}
Reply post_end(const Call& c) {
  c.bench.end();
  return json_reply(R"({"ending":true})");
}

Reply get_attributes(const Call& c) try {
  Json list = Json::array();
  for (const auto& [name, value] : c.bench.attributes()) list.push_back({{"name", name}, {"value", value}});
  return json_reply(list.dump(-1, ' ', false, Json::error_handler_t::replace));
} catch (const rigs::RigError& e) {
  throw Problem{503, e.what()};
}

Reply get_interlocks(const Call&) {
  Json list = Json::array();
  for (const auto& i : rigs::interlock_list())
    list.push_back({{"number", i.number},
                    {"name", i.name},
                    {"watched", i.watched},
                    {"reaction", i.reaction},
                    {"limit", i.limit},
                    {"when", i.when},
                    {"cleared", i.cleared},
                    {"advice", i.advice}});
  return json_reply(list.dump());
}

Reply get_access(const Call& c) {
  return json_reply(
      Json{{"may_fire", c.access.right(c.request) == Right::fire}, {"link_token", c.access.link_token()}}
          .dump());
}

/// What comes over the WebSocket is sent by HttpServer; this is for whoever asks without one.
Reply want_websocket(const Call&) {
  throw Problem{426,
                "this is a WebSocket: it sends, and takes nothing; a single answer is at /api/bench and "
                "/api/shots/{id}/record"};
}

constexpr const char* state_example =
    R"({"version": "", "rig": {}, "link": {}, "status": {}, "plan": {}, "job": {}, "aiming": false,
          "ended": {}, "newest_shot": 1, "newest_aim_deg": 90, "newest_prediction": 1,
         "newest_campaign": 1,
          "interrupted": [{"shot": 1, "campaign": 1, "angle_deg": 90}],
          "stop": {"off": true, "text": "", "ms": 1}, "log": [""]})";

constexpr Route of_bench[] = {
    {"GET", "/api/access", Right::read,
     "What the token of this request may do, and one for addresses, which may read until the program ends.",
     "", R"({"may_fire": true, "link_token": ""})", get_access},
    {"GET", "/api/bench", Right::read, "Rig, link, job, newest shot, log.", "", state_example, get_bench},
    {"GET",
     state_stream,
     Right::read,
     "WebSocket: what GET /api/bench answers, whenever it has changed, at most 25 times a second.",
     "",
     state_example,
     want_websocket,
     {},
     nullptr,
     true},
    {"GET",
     record_stream,
     Right::read,
     "WebSocket: the newest record in the form of GET /api/shots/{id}/record, at most 25 times a second.",
     "",
     "application/octet-stream",
     want_websocket,
     {},
     nullptr,
     true},
    {"POST", "/api/stop", Right::none,
     "Coil off and job over. `off` is true once the rig has confirmed it; 504 where it has not.", "",
     R"({"off": true, "text": "", "ms": 1})", post_stop},
    {"POST", "/api/acknowledge", Right::fire,
     "Ends the rig's latched fault of this number once its cause is gone. Nothing is switched on.",
     R"({"fault": 1})", R"({"acknowledged": true})", post_acknowledge},
    {"POST",
     "/api/fire",
     Right::fire,
     "One closing under the plan's conditions: the coil switched on at `angle_deg` of the mains, or the "
     "contacts touching at "
     "`touch_deg` after the simulator.",
     R"({"angle_deg": 90})",
     R"({"started": true})",
     post_fire,
     {},
     "touch_deg"},
    {"POST", "/api/prepare", Right::fire,
     "This closing may come next: it is simulated already, so that its picture is there sooner. Nothing is "
     "fired or stored.",
     R"({"angle_deg": 90})", R"({"preparing": true})", post_prepare},
    {"POST", "/api/plan/run", Right::fire, "Fires a plan and stores every shot.",
     R"({"text": "angles_deg = [0, 90]\nrepeats = 3"})", R"({"started": true})", post_run},
    {"POST", "/api/plan/pause", Right::fire, "Waits between two shots, or goes on.", R"({"on": true})",
     R"({"paused": true})", post_pause},
    {"POST", "/api/plan/end", Right::fire, "The shot in flight is the last one.", "{}", R"({"ending": true})",
     post_end},
    {"GET", "/api/rig/attributes", Right::read, "Every attribute of the rig and its value.", "",
     R"([{"name": "", "value": ""}])", get_attributes},
    {"GET", "/api/rig/interlocks", Right::read,
     "What the firmware watches and what it does then (docs/reference/faults.md), as of this program's own "
     "firmware.",
     "",
     R"([{"number": 1, "name": "", "watched": "", "reaction": "", "limit": "", "when": "", "cleared": "",
          "advice": ""}])",
     get_interlocks},
};

}  // namespace

std::span<const Route> bench_calls() {
  return of_bench;
}

}  // namespace powbench::host
