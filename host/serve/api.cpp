#include "host/serve/api.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "core/version.h"
#include "host/compare/compare.h"
#include "host/serve/documents.h"
#include "host/serve/page.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;

/// The request was understood and cannot be met.
struct Problem {
  int status;
  std::string text;
};

struct Call {
  Bench& bench;
  const Access& access;
  const Request& request;
  std::int64_t id = 0;  ///< of the path
  Json body;            ///< of a POST
};

Reply json(const Json& j, int status = 200) {
  Reply r;
  r.status = status;
  r.body = j.dump(-1, ' ', false, Json::error_handler_t::replace);  // a client's bytes may be no UTF-8
  return r;
}

/// A finite number of the body within `low` .. `high`.
double number(const Json& body, const char* key, double low, double high) {
  const auto it = body.find(key);
  if (it == body.end() || !it->is_number())
    throw Problem{400, fmt::format("'{}' is missing: a number from {:g} to {:g}", key, low, high)};
  const double x = it->get<double>();
  if (!(x >= low && x <= high))
    throw Problem{400, fmt::format("'{}' = {:g} is outside {:g} to {:g}", key, x, low, high)};
  return x;
}

bool flag(const Json& body, const char* key) {
  const auto it = body.find(key);
  if (it == body.end() || !it->is_boolean())
    throw Problem{400, fmt::format("'{}' is missing: true or false", key)};
  return it->get<bool>();
}

std::string text(const Json& body, const char* key, std::size_t longest) {
  const auto it = body.find(key);
  if (it == body.end() || !it->is_string()) throw Problem{400, fmt::format("'{}' is missing: a text", key)};
  auto value = it->get<std::string>();
  if (value.size() > longest)
    throw Problem{400, fmt::format("'{}' has more than {} characters", key, longest)};
  return value;
}

/// The plan of the body on the bench's own specimen: a plan from elsewhere names no file here.
Scene scene_of(const Call& c) {
  const Scene now = c.bench.scene();
  Plan plan = parse_plan(text(c.body, "text", 100'000), "plan");
  plan.folder = now.plan.folder;
  if (plan.specimen != now.plan.specimen)
    throw BadInput(
        {fmt::format("plan: specimen = \"{}\": the specimen is the one this bench was started "
                     "with; allowed \"{}\"",
                     plan.specimen, now.plan.specimen)});
  return make_scene(std::move(plan));
}

Json started() {
  return {{"started", true}};
}

// ---- the calls ----

Reply get_bench(const Call& c) {
  Reply r;
  r.body = c.bench.state();
  return r;
}

Reply post_stop(const Call& c) {
  const StopAnswer a = c.bench.stop();
  return json({{"off", a.off}, {"text", a.text}, {"ms", a.ms}}, a.off ? 200 : 504);
}

Reply post_fire(const Call& c) {
  c.bench.fire(radians(number(c.body, "angle_deg", 0, 359.99)));
  return json(started(), 202);
}

Reply get_plan(const Call& c) {
  return json({{"text", c.bench.scene().plan_text}});
}
Reply get_template(const Call&) {
  return json({{"text", plan_template()}});
}

/// Mistakes are what was asked for: status 200.
Reply post_check(const Call& c) try {
  const Scene s = scene_of(c);
  Json shots = Json::array();
  for (const PlannedShot& p : s.shots)
    shots.push_back({{"number", p.index + 1},
                     {"repeat", p.repeat + 1},
                     {"angle_deg", degrees(effective_angle(p.conditions))},
                     {"supply_volts", p.conditions.supply_volts},
                     {"mains_hertz", p.conditions.mains_hertz}});
  const double seconds = estimated_seconds(s.plan),
               on = s.plan.hold_time * static_cast<double>(s.shots.size());
  return json({{"name", s.plan.name},
               {"seconds", seconds},
               {"coil_on_percent", seconds > 0 ? 100 * on / seconds : 0},
               {"shots", shots}});
} catch (const BadInput& e) {
  return json({{"errors", e.errors()}});
}
Reply post_run(const Call& c) {
  c.bench.run(scene_of(c));
  return json(started(), 202);
}
Reply post_hold(const Call& c) {
  const bool on = flag(c.body, "on");
  c.bench.hold(on);
  return json({{"held", on}});
}
Reply post_end(const Call& c) {
  c.bench.end();
  return json({{"ending", true}});
}

Store reader(const Call& c) {
  return Store(c.bench.database(), Store::Mode::read_only);
}
CampaignInfo campaign_of(const Call& c, const Store& store) {
  for (CampaignInfo& info : store.campaigns())
    if (info.id == c.id) return info;
  throw Problem{404, fmt::format("there is no campaign {}", c.id)};
}

Reply get_campaigns(const Call& c) {
  Reply r;
  r.body = campaigns_document(reader(c));
  return r;
}
Reply get_shots(const Call& c) {
  const Store store = reader(c);
  Reply r;
  r.body = shots_document(store, campaign_of(c, store));
  return r;
}
Reply get_report(const Call& c) {
  const Store store = reader(c);
  Reply r;
  r.type = "text/html; charset=utf-8";
  r.policy = report_policy;
  r.body = report_document(store, campaign_of(c, store));
  return r;
}
Reply get_annotations(const Call& c) {
  const Store store = reader(c);
  Json list = Json::array();
  for (const Annotation& a : store.annotations(campaign_of(c, store).id))
    list.push_back({{"created", a.created}, {"key", a.key}, {"text", a.text}});
  return json(list);
}
Reply post_annotation(const Call& c) {
  const std::string key = text(c.body, "key", 40), what = text(c.body, "text", 2000);
  TestRecord unused;
  complete(unused, key, what);  // refuses what no report could read
  Store store(c.bench.database());
  store.annotate(campaign_of(c, store).id, key, what);
  return json({{"key", key}, {"text", what}}, 201);
}

StoredShot shot_of(const Call& c, const Store& store) {
  try {
    return store.shot(c.id);
  } catch (const StoreError&) {
    throw Problem{404, fmt::format("there is no shot {}", c.id)};
  }
}
Reply get_shot(const Call& c) {
  const Store store = reader(c);
  Reply r;
  r.body = shot_document(store, shot_of(c, store));
  return r;
}
Reply get_closing(const Call& c) {
  const Store store = reader(c);
  const StoredShot s = shot_of(c, store);
  if (s.record_hash.empty()) throw Problem{404, fmt::format("shot {} has no record", s.id)};
  Reply r;
  r.body = closing_document(store, s);
  return r;
}
Reply get_waveforms(const Call& c) {
  const Store store = reader(c);
  const StoredShot s = shot_of(c, store);
  if (s.record_hash.empty()) throw Problem{404, fmt::format("shot {} has no record", s.id)};
  Reply r;
  r.type = "text/csv; charset=utf-8";
  r.body = waveforms_document(store, s);
  return r;
}

Reply get_openapi(const Call&) {
  Reply r;
  r.body = openapi();
  return r;
}

struct Route {
  const char* method;
  const char* path;  ///< {id} stands for a number
  Right right;
  const char* meaning;
  const char* body;  ///< example of the body of a POST, "" = none
  Reply (*act)(const Call&);
};

constexpr Route routes[] = {
    {"GET", "/api", Right::none, "This description.", "", get_openapi},
    {"GET", "/api/bench", Right::read, "Rig, link, job, newest shot, log.", "", get_bench},
    {"POST", "/api/stop", Right::none,
     "Coil off and job over. `off` is true once the rig has confirmed it; 504 where it has not.", "",
     post_stop},
    {"POST", "/api/fire", Right::fire, "One closing at an angle of the mains, under the plan's conditions.",
     R"({"angle_deg": 90})", post_fire},
    {"GET", "/api/plan", Right::read, "The plan in force, as TOML.", "", get_plan},
    {"GET", "/api/plan/template", Right::read, "A commented plan with every key.", "", get_template},
    {"POST", "/api/plan/check", Right::read, "Every mistake of a plan, or its shots, duration and duty.",
     R"({"text": "angles_deg = [0, 90]\nrepeats = 3"})", post_check},
    {"POST", "/api/plan/run", Right::fire, "Fires a plan and stores every shot.",
     R"({"text": "angles_deg = [0, 90]\nrepeats = 3"})", post_run},
    {"POST", "/api/plan/hold", Right::fire, "Waits between two shots, or goes on.", R"({"on": true})",
     post_hold},
    {"POST", "/api/plan/end", Right::fire, "The shot in flight is the last one.", "{}", post_end},
    {"GET", "/api/campaigns", Right::read, "All campaigns of the store, the newest first.", "",
     get_campaigns},
    {"GET", "/api/campaigns/{id}/shots", Right::read, "Shots of a campaign with their quantities and u.", "",
     get_shots},
    {"GET", "/api/campaigns/{id}/report.html", Right::read, "The report.", "", get_report},
    {"GET", "/api/campaigns/{id}/annotations", Right::read, "What was learned later.", "", get_annotations},
    {"POST", "/api/campaigns/{id}/annotations", Right::fire, "Adds to the test record.",
     R"({"key": "remarks", "text": "coil was warm"})", post_annotation},
    {"GET", "/api/shots/{id}", Right::read,
     "One shot: conditions, outcome, quantities with u, simulated ones.", "", get_shot},
    {"GET", "/api/shots/{id}/closing", Right::read, "Its curves, measured and simulated, and marks.", "",
     get_closing},
    {"GET", "/api/shots/{id}/waveforms.csv", Right::read, "Its channels, every sample.", "", get_waveforms},
};

/// The id where the path fits the pattern; 0 without one.
std::optional<std::int64_t> fits(std::string_view path, std::string_view pattern) {
  const auto hole = pattern.find("{id}");
  if (hole == std::string_view::npos) return path == pattern ? std::optional<std::int64_t>(0) : std::nullopt;
  const std::string_view before = pattern.substr(0, hole), behind = pattern.substr(hole + 4);
  if (!path.starts_with(before) || path.size() < before.size() + behind.size() || !path.ends_with(behind))
    return std::nullopt;
  const std::string_view digits = path.substr(before.size(), path.size() - before.size() - behind.size());
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), id);
  if (error != std::errc{} || end != digits.data() + digits.size() || id <= 0) return std::nullopt;
  return id;
}

Reply act(const Route& route, Call call) {
  const Request& r = call.request;
  if (route.right > call.access.right(r.token))
    throw Problem{401, route.right == Right::fire
                           ? "this needs a token that may fire (Authorization: Bearer TOKEN)"
                           : "this needs a token (Authorization: Bearer TOKEN)"};
  if (*route.body != '\0') {
    if (!r.content_type.starts_with("application/json"))
      throw Problem{415, "the body is JSON: Content-Type: application/json"};
    call.body = Json::parse(r.body, nullptr, false);
    if (!call.body.is_object())
      throw Problem{400, fmt::format("the body is no JSON object; such as {}", route.body)};
  }
  return route.act(call);
}

Reply refuse(int status, const std::string& why) {
  return json({{"error", why}}, status);
}

}  // namespace

Reply Api::answer(const Request& r) const {
  try {
    if (const std::string why = access_.foreign(r); !why.empty()) return refuse(403, why);
    if (r.method == "GET")
      if (auto file = page_file(r.path, access_.page_token())) return *file;
    bool known = false;
    for (const Route& route : routes)
      if (const auto id = fits(r.path, route.path)) {
        known = true;
        if (r.method == route.method) return act(route, {bench_, access_, r, *id, {}});
      }
    if (known) return refuse(405, r.method + " is not for this address; GET /api lists all calls");
    return refuse(404, "there is nothing at this address; GET /api lists all calls");
  } catch (const Problem& p) {
    return refuse(p.status, p.text);
  } catch (const BadInput& e) {
    return json({{"errors", e.errors()}}, 422);
  } catch (const NotNow& e) {
    return refuse(409, e.what());
  } catch (const std::exception& e) {
    return refuse(500, e.what());
  }
}

Reply Api::listen(const Request& r) const {
  if (const std::string why = access_.foreign(r); !why.empty()) return refuse(403, why);
  if (access_.right(r.token) < Right::read) return refuse(401, "this needs a token");
  return {};
}

std::string openapi() {
  Json paths = Json::object();
  for (const Route& route : routes) {
    std::string method = route.method;
    for (char& c : method) c = static_cast<char>(c | 0x20);
    Json operation = {
        {"summary", route.meaning},
        {"security", route.right == Right::none ? Json::array() : Json::array({{{"token", Json::array()}}})},
        {"responses", {{"default", {{"description", "200..202, or {\"error\"} or {\"errors\"}"}}}}}};
    if (std::string_view(route.path).find("{id}") != std::string_view::npos)
      operation["parameters"] = {{{"name", "id"},
                                  {"in", "path"},
                                  {"required", true},
                                  {"schema", {{"type", "integer"}, {"minimum", 1}}}}};
    if (*route.body != '\0')
      operation["requestBody"] = {
          {"required", true},
          {"content",
           {{"application/json", {{"schema", {{"type", "object"}}}, {"example", Json::parse(route.body)}}}}}};
    paths[route.path][method] = operation;
  }
  return Json{{"openapi", "3.0.3"},
              {"info", {{"title", "powbench live bench"}, {"version", program_version}}},
              {"components", {{"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}}}},
              {"paths", paths}}
      .dump();
}

}  // namespace powbench::host
