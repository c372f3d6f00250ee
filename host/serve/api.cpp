#include "host/serve/api.h"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "core/version.h"
#include "host/serve/calls.h"
#include "host/serve/page.h"

namespace powbench::host {

using Json = nlohmann::ordered_json;

struct Body {
  Json json;
};

namespace {

std::string json_text(const Json& j) {
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);  // a client's bytes may be no UTF-8
}

}  // namespace

Reply json_reply(std::string json, int status) {
  Reply r;
  r.status = status;
  r.body = std::move(json);
  return r;
}

double number_of(const Body& body, const char* key, double low, double high) {
  const auto it = body.json.find(key);
  if (it == body.json.end() || !it->is_number())
    throw Problem{400, fmt::format("'{}' {}: a number from {:g} to {:g}", key,
                                   it == body.json.end() ? "is missing" : "is no number", low, high)};
  const double x = it->get<double>();
  if (!(x >= low && x <= high))
    throw Problem{400, fmt::format("'{}' = {:g} is outside {:g} to {:g}", key, x, low, high)};
  return x;
}

bool has(const Body& body, const char* key) {
  return body.json.contains(key);
}

bool flag_of(const Body& body, const char* key) {
  const auto it = body.json.find(key);
  if (it == body.json.end() || !it->is_boolean())
    throw Problem{400, fmt::format("'{}' is missing: true or false", key)};
  return it->get<bool>();
}

std::string text_of(const Body& body, const char* key, std::size_t longest) {
  const auto it = body.json.find(key);
  if (it == body.json.end() || !it->is_string())
    throw Problem{400, fmt::format("'{}' is missing: a text", key)};
  auto value = it->get<std::string>();
  if (value.size() > longest)
    throw Problem{400, fmt::format("'{}' has more than {} characters", key, longest)};
  return value;
}

std::int64_t number_of_query(const Call& c, const char* key) {
  const std::string value = of_query(c.request.query, key);
  if (value.empty()) return 0;
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), id);
  if (error != std::errc{} || end != value.data() + value.size() || id < 0)
    throw Problem{400, fmt::format("'{0}={1}' in the address: a whole number is wanted, as in {0}=1", key,
                                   value.substr(0, 40))};
  return id;
}

namespace {

Reply get_openapi(const Call&) {
  return json_reply(openapi());
}
constexpr Route self[] = {{"GET", "/api", Right::none, "This description.", "",
                           R"({"openapi": "", "info": {}, "components": {}, "paths": {}})", get_openapi}};

const std::vector<Route>& all_calls() {
  static const std::vector<Route> all = [] {
    std::vector<Route> list(std::begin(self), std::end(self));
    for (const auto& part : {bench_calls(), file_calls(), document_calls()})
      list.insert(list.end(), part.begin(), part.end());
    return list;
  }();
  return all;
}

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

/// Refuses an object that names a key twice: which of the two values was meant is not known.
Json::parser_callback_t one_value_a_key() {
  return [open = std::vector<std::set<std::string>>()](int, Json::parse_event_t event, Json& parsed) mutable {
    if (event == Json::parse_event_t::object_start) open.emplace_back();
    if (event == Json::parse_event_t::object_end) open.pop_back();
    if (event == Json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second)
      throw Problem{400, fmt::format("key '{}' stands there twice", parsed.get<std::string>().substr(0, 40))};
    return true;
  };
}

Reply act(const Route& route, const Call& call, Body& body, const Access& access) {
  const Request& r = call.request;
  if (route.right > access.right(r))
    throw Problem{401, route.right == Right::fire
                           ? "this needs a token that may fire (Authorization: Bearer TOKEN)"
                           : "this needs a token (Authorization: Bearer TOKEN)"};
  if (*route.body != '\0') {
    if (!r.content_type.starts_with("application/json"))
      throw Problem{415, "the body is JSON: Content-Type: application/json"};
    body.json = Json::parse(r.body, one_value_a_key(), false);
    if (!body.json.is_object())
      throw Problem{400, fmt::format("the body is no JSON object; such as {}", route.body)};
    // a word that is not understood may be what the closing was to be like
    const Json example = Json::parse(route.body);
    const std::string other = route.other_key ? route.other_key : "";
    for (const auto& [key, value] : body.json.items())
      if (!example.contains(key) && key != other) {
        std::string known = other;
        for (const auto& [word, unused] : example.items()) known += (known.empty() ? "" : ", ") + word;
        throw Problem{400, fmt::format("unknown key '{}'; known: {}", key.substr(0, 40),
                                       known.empty() ? "none" : known)};
      }
  }
  return route.act(call);
}

Reply refuse(int status, const std::string& why) {
  return json_reply(json_text(Json{{"error", why}}), status);
}

}  // namespace

Reply Api::answer(const Request& r) const {
  try {
    if (const std::string why = access_.foreign(r); !why.empty()) return refuse(403, why);
    if (r.method == "GET")
      if (auto file = page_file(r.path, access_.page_token())) return *file;
    bool known = false;
    for (const Route& route : all_calls())
      if (const auto id = fits(r.path, route.path)) {
        known = true;
        if (r.method != route.method) continue;
        Body body;
        return act(route, {bench_, facts_, access_, plan_file_, r, *id, body}, body, access_);
      }
    if (known) return refuse(405, r.method + " is not for this address; GET /api lists all calls");
    return refuse(404, "there is nothing at this address; GET /api lists all calls");
  } catch (const Problem& p) {
    return refuse(p.status, p.text);
  } catch (const BadInput& e) {
    return json_reply(json_text(Json{{"errors", e.errors()}}), 422);
  } catch (const NotNow& e) {
    return refuse(409, e.what());
  } catch (const std::exception& e) {
    return refuse(500, e.what());
  }
}

Reply Api::listen(const Request& r) const {
  if (const std::string why = access_.foreign(r); !why.empty()) return refuse(403, why);
  if (access_.right(r) < Right::read) return refuse(401, "this needs a token");
  return {};
}

namespace {

/// The shape of an example.
Json schema_of(const Json& example) {
  if (example.is_object()) {
    Json properties = Json::object();
    for (const auto& [key, value] : example.items()) properties[key] = schema_of(value);
    return {{"type", "object"}, {"properties", properties}};
  }
  if (example.is_array())
    return {{"type", "array"}, {"items", example.empty() ? Json::object() : schema_of(example[0])}};
  if (example.is_null()) return {{"nullable", true}};
  return {{"type", example.is_string() ? "string" : example.is_boolean() ? "boolean" : "number"}};
}

/// The example of a body with every key that it may have.
Json body_keys(const Route& route) {
  Json keys = Json::parse(route.body);
  if (route.other_key) keys[route.other_key] = 90;
  return keys;
}

Json responses(const Route& route) {
  const std::string reply = route.reply;
  Json content;
  if (reply.starts_with("{") || reply.starts_with("["))
    content["application/json"] = {{"schema", schema_of(Json::parse(reply))}};
  else
    content[reply] = {{"schema", {{"type", "string"}}}};
  const Json refused = {{"description", "{\"error\": sentence} or {\"errors\": [sentences]}"},
                        {"content", {{"application/json", {{"schema", {{"type", "object"}}}}}}}};
  if (route.stream)
    return {{"101", {{"description", "a WebSocket; each of its messages:"}, {"content", content}}},
            {"426", refused},
            {"default", refused}};
  return {{"2XX", {{"description", "done"}, {"content", content}}}, {"default", refused}};
}

}  // namespace

std::string openapi() {
  Json paths = Json::object();
  for (const Route& route : all_calls()) {
    std::string method = route.method;
    for (char& c : method) c = static_cast<char>(c | 0x20);
    Json operation = {
        {"summary", route.meaning},
        {"security", route.right == Right::none ? Json::array() : Json::array({{{"token", Json::array()}}})},
        {"responses", responses(route)}};
    const auto parameter = [&](const char* name, const char* place, bool required, int least) {
      operation["parameters"].push_back({{"name", name},
                                         {"in", place},
                                         {"required", required},
                                         {"schema", {{"type", "integer"}, {"minimum", least}}}});
    };
    if (std::string_view(route.path).find("{id}") != std::string_view::npos) parameter("id", "path", true, 1);
    if (route.stream)  // a browser sends no header with it
      operation["parameters"].push_back(
          {{"name", "token"}, {"in", "query"}, {"required", false}, {"schema", {{"type", "string"}}}});
    for (const char* name : route.query)
      if (name != nullptr) parameter(name, "query", std::string_view(name) != "after", 0);
    if (*route.body != '\0')
      operation["requestBody"] = {
          {"required", true},
          {"content",
           {{"application/json",
             {{"schema", schema_of(body_keys(route))}, {"example", Json::parse(route.body)}}}}}};
    paths[route.path][method] = operation;
  }
  return Json{{"openapi", "3.0.3"},
              {"info", {{"title", "powbench live bench"}, {"version", program_version}}},
              {"components", {{"securitySchemes", {{"token", {{"type", "http"}, {"scheme", "bearer"}}}}}}},
              {"paths", paths}}
      .dump();
}

}  // namespace powbench::host
