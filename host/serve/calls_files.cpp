#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/compare/compare.h"
#include "host/config/edit_text.h"
#include "host/config/file_kind.h"
#include "host/gather/scene.h"
#include "host/serve/calls.h"
#include "host/serve/files.h"

/// Plan, specimen and rig file: read, checked, edited key by key, stored where the bench was started from.

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::size_t longest_text = 100'000;

/// One of the three files; its parser throws BadInput.
struct Parameters {
  const char* kind;
  fs::path (*file)(const Call&);         ///< empty: the bench was started without one
  std::string (*in_force)(const Call&);  ///< resolved
  std::vector<KeyLine> (*keys)(const Call&, std::string text);
  std::vector<KeyLine> (*defaults)();
  std::string (*commented)();                           ///< template
  std::string (*saved)(const Call&, std::string text);  ///< after it was written: what follows from it
};

Plan plan_of(const Call& c, std::string text) {
  const Scene now = c.bench.scene();
  Plan plan = parse_plan(std::move(text), "plan");
  plan.folder = now.plan.folder;
  if (plan.specimen != now.plan.specimen)
    throw BadInput({fmt::format(
        "plan: specimen = \"{}\": the specimen is the one this bench was started with; allowed \"{}\"",
        plan.specimen, now.plan.specimen)});
  return plan;
}

RigFile rig_of(const Call& c, std::string text) {
  RigFile rig = parse_rig(std::move(text), "rig");
  const RigFile& now = c.bench.rig_file();
  rig.folder = now.folder;
  if (rig.specimen != now.specimen)
    throw BadInput({fmt::format(
        "rig: specimen = \"{}\": the device is the one this bench was started with; allowed \"{}\"",
        rig.specimen, now.specimen)});
  return rig;
}

const Parameters plan_parameters{
    "plan",
    [](const Call& c) { return fs::path(c.plan_file); },
    [](const Call& c) { return c.bench.scene().plan_text; },
    [](const Call& c, std::string text) { return keys_of(plan_of(c, std::move(text))); },
    [] { return keys_of(Plan{}); },
    plan_template,
    [](const Call& c, std::string text) -> std::string {
      c.bench.adopt(make_scene(plan_of(c, std::move(text))));
      return "used from now on, for single closings and the next run";
    }};
const Parameters specimen_parameters{
    "specimen",
    [](const Call& c) {
      const Plan plan = c.bench.scene().plan;
      return plan.specimen.empty() ? fs::path() : plan.folder / plan.specimen;
    },
    [](const Call& c) { return c.bench.scene().specimen_text; },
    [](const Call&, std::string text) { return keys_of(parse_specimen(std::move(text), "specimen")); },
    [] { return keys_of(sim::Specimen{}); },
    specimen_template,
    [](const Call& c, std::string) -> std::string {
      c.bench.adopt(make_scene(c.bench.scene().plan));
      return "the next closings are simulated with it; a simulated rig keeps its device until powbench serve "
             "is started anew";
    }};
const Parameters rig_parameters{
    "rig",
    [](const Call& c) {
      const std::string& uri = c.bench.rig_uri();
      return rigs::is_simulated(uri) ? fs::path(uri.substr(uri.find(':') + 1)) : fs::path();
    },
    [](const Call& c) { return resolved_text(c.bench.rig_file()); },
    [](const Call& c, std::string text) { return keys_of(rig_of(c, std::move(text))); },
    [] { return keys_of(RigFile{}); },
    rig_template,
    [](const Call&, std::string) -> std::string {
      return "the simulated rig keeps what it was started with until powbench serve is started anew";
    }};

std::string file_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The file itself where it says what is in force, with its comments; else what a person would write.
Reply get(const Call& c, const Parameters& p) {
  const fs::path file = p.file(c);
  const std::string force = p.in_force(c);
  const std::vector<KeyLine> now = p.keys(c, force);
  std::string text;
  if (!file.empty()) try {
      const std::string own = file_text(file);
      const std::vector<KeyLine> stored = p.keys(c, own);
      bool same = true;
      for (std::size_t i = 0; i < stored.size(); ++i) same = same && stored[i].value == now[i].value;
      if (same) text = own;
    } catch (const BadInput&) {  // somebody is at work on it
    }
  if (text.empty()) text = written_file(p.kind, now, p.defaults());
  return json_reply(Json{
      {"file", file.empty() ? Json(nullptr) : Json(file.filename().string())},
      {"text", text},
      {"template",
       p.commented()}}.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// What a plan would fire: every shot with its time, all together with duration and duty.
Json fired(const Scene& s) {
  const double seconds = estimated_seconds(s.plan);
  const auto n = static_cast<double>(s.shots.size());
  const double each = n > 1 ? (seconds + s.plan.pause) / n : seconds;
  Json shots = Json::array();
  for (const PlannedShot& p : s.shots)
    shots.push_back({{"number", p.index + 1},
                     {"repeat", p.repeat + 1},
                     {"at_s", each * p.index},
                     {"angle_deg", degrees(effective_angle(p.conditions))},
                     {"supply_volts", p.conditions.supply_volts},
                     {"mains_hertz", p.conditions.mains_hertz}});
  return {{"name", s.plan.name},
          {"seconds", seconds},
          {"coil_on_s", s.plan.hold_time * n},
          {"coil_on_percent", seconds > 0 ? 100 * s.plan.hold_time * n / seconds : 0},
          {"shots", shots}};
}

/// Mistakes are what was asked for: status 200.
Reply check(const Call& c, const Parameters& p) try {
  const std::string text = text_of(c.body, "text", longest_text);
  const std::vector<KeyLine> keys = p.keys(c, text), defaults = p.defaults();
  Json list = Json::array();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const KeyLine& k = keys[i];
    list.push_back({{"section", k.section},
                    {"section_meaning", k.section_meaning},
                    {"key", k.key},
                    {"unit", k.unit},
                    {"allowed", k.allowed},
                    {"meaning", k.meaning},
                    {"value", k.value},
                    {"default", i < defaults.size() ? defaults[i].value : ""},
                    {"required", k.required}});
  }
  Json out = {{"errors", Json::array()}, {"keys", list}};
  if (std::string_view(p.kind) == "plan") out["fired"] = fired(make_scene(plan_of(c, text)));
  return json_reply(out.dump(-1, ' ', false, Json::error_handler_t::replace));
} catch (const BadInput& e) {
  return json_reply(Json{{"errors", e.errors()}}.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// One key with another value. The value may be wrong: then the check says so, with its range.
Reply set(const Call& c, const Parameters& p) {
  const std::string text = text_of(c.body, "text", longest_text), section = text_of(c.body, "section", 100),
                    key = text_of(c.body, "key", 100);
  std::string value = text_of(c.body, "value", 2000);
  if (value.find_first_of("\n\r") != std::string::npos) throw Problem{400, "'value' is one line"};
  const KeyLine* line = nullptr;
  const std::vector<KeyLine> known = p.defaults();
  for (const KeyLine& k : known)
    if (k.section == section && k.key == key) line = &k;
  if (line == nullptr)
    throw Problem{404, fmt::format("a {} file has no key '{}' in section '{}'", p.kind, key, section)};
  const bool list = line->value.starts_with('[') || line->meaning.find("a list") != std::string::npos;
  if (list && !value.empty() && value.find_first_not_of("0123456789+-.eE, \t") == std::string::npos)
    value = "[" + value + "]";
  if (line->words && !value.empty() && !value.starts_with('"')) value = host::quoted(value);
  return json_reply(Json{{"text", with_value(text, section, key, value)}}.dump(
      -1, ' ', false, Json::error_handler_t::replace));
}

Reply save(const Call& c, const Parameters& p) {
  const std::string text = text_of(c.body, "text", longest_text);
  p.keys(c, text);  // throws with all mistakes
  const fs::path file = p.file(c);
  if (file.empty())
    throw NotNow(fmt::format(
        "the bench was started without a {0} file, so there is none to write; download the text and start "
        "powbench serve with it",
        p.kind));
  if (std::string_view(p.kind) != "rig") c.bench.adopt(c.bench.scene());  // refuses while a job is on
  replace_file(file.string(), text);
  return json_reply(Json{{"file", file.filename().string()}, {"note", p.saved(c, text)}}.dump());
}

/// The plan of single closings with another voltage or hold time; in its range, or BadInput says so.
Reply post_conditions(const Call& c) {
  const Scene now = c.bench.scene();
  std::string text = now.plan_text;
  for (const char* key : {"supply_volts", "hold_time_ms"})
    if (has(c.body, key))
      text = with_value(text, "", key, fmt::format("{}", number_of(c.body, key, -1e9, 1e9)));
  const Scene next = make_scene(plan_of(c, text));
  if (next.plan_hash != now.plan_hash) c.bench.adopt(next);
  return json_reply(
      Json{{"supply_volts", next.plan.supply_volts}, {"hold_time_ms", 1e3 * next.plan.hold_time}}.dump());
}

// one row of the table for each file and action
Reply get_plan(const Call& c) {
  return get(c, plan_parameters);
}
Reply check_plan(const Call& c) {
  return check(c, plan_parameters);
}
Reply set_plan(const Call& c) {
  return set(c, plan_parameters);
}
Reply save_plan(const Call& c) {
  return save(c, plan_parameters);
}
Reply get_specimen(const Call& c) {
  return get(c, specimen_parameters);
}
Reply check_specimen(const Call& c) {
  return check(c, specimen_parameters);
}
Reply set_specimen(const Call& c) {
  return set(c, specimen_parameters);
}
Reply save_specimen(const Call& c) {
  return save(c, specimen_parameters);
}
Reply get_rig(const Call& c) {
  return get(c, rig_parameters);
}
Reply check_rig(const Call& c) {
  return check(c, rig_parameters);
}
Reply set_rig(const Call& c) {
  return set(c, rig_parameters);
}
Reply save_rig(const Call& c) {
  return save(c, rig_parameters);
}

constexpr const char *plan_example = R"({"text": "angles_deg = [0, 90]\nrepeats = 3"})",
                     *specimen_example = R"({"text": "[bridges]\ngap_mm = 2.5"})",
                     *rig_example = R"({"text": "pretrigger_ms = 10"})";
constexpr const char
    *text_and_template = R"({"file": "", "text": "", "template": ""})",
    *check_reply = R"({"errors": [""], "keys": [{"section": "", "section_meaning": "", "key": "", "unit": "",
  "allowed": "", "meaning": "", "value": "", "default": "", "required": true}]})",
    *plan_reply = R"({"errors": [""], "keys": [{"section": "", "section_meaning": "", "key": "", "unit": "",
  "allowed": "", "meaning": "", "value": "", "default": "", "required": true}], "fired": {"name": "",
  "seconds": 1, "coil_on_s": 1, "coil_on_percent": 1, "shots": [{"number": 1, "repeat": 1, "at_s": 0,
  "angle_deg": 0, "supply_volts": 0,
  "mains_hertz": 0}]}})",
    *text_reply = R"({"text": ""})", *save_reply = R"({"file": "", "note": ""})";
constexpr const char
    *getting =
        "The file in force with its own comments, or what a person would write; and a commented one with "
        "every key.",
    *checking = "Every mistake of a text, or every key with its value, unit, range and meaning.",
    *setting = "The text with another value for one key; its other lines stay. \"\" takes the key out.",
    *saving = "Writes the file that the bench was started with, after the same check.";

constexpr Route of_files[] = {
    {"POST", "/api/conditions", Right::fire,
     "Single closings have this voltage and hold time from now on; what is left out stays. A campaign of its "
     "own.",
     R"({"supply_volts": 230, "hold_time_ms": 100})", R"({"supply_volts": 230, "hold_time_ms": 100})",
     post_conditions},
    {"GET", "/api/files/plan", Right::read, getting, "", text_and_template, get_plan},
    {"POST", "/api/files/plan/check", Right::read,
     "Every mistake of a plan, or its keys and what it would fire: every shot, the time, the duty of the "
     "coil.",
     plan_example, plan_reply, check_plan},
    {"POST", "/api/files/plan/set", Right::read, setting,
     R"({"text": "angles_deg = [0, 90]\nrepeats = 3", "section": "", "key": "repeats", "value": "5"})",
     text_reply, set_plan},
    {"POST", "/api/files/plan/save", Right::fire, saving, plan_example, save_reply, save_plan},
    {"GET", "/api/files/specimen", Right::read, getting, "", text_and_template, get_specimen},
    {"POST", "/api/files/specimen/check", Right::read, checking, specimen_example, check_reply,
     check_specimen},
    {"POST", "/api/files/specimen/set", Right::read, setting,
     R"({"text": "", "section": "bridges", "key": "gap_mm", "value": "2.6"})", text_reply, set_specimen},
    {"POST", "/api/files/specimen/save", Right::fire, saving, specimen_example, save_reply, save_specimen},
    {"GET", "/api/files/rig", Right::read, getting, "", text_and_template, get_rig},
    {"POST", "/api/files/rig/check", Right::read, checking, rig_example, check_reply, check_rig},
    {"POST", "/api/files/rig/set", Right::read, setting,
     R"({"text": "", "section": "", "key": "pretrigger_ms", "value": "20"})", text_reply, set_rig},
    {"POST", "/api/files/rig/save", Right::fire, saving, rig_example, save_reply, save_rig},
};

}  // namespace

Scene scene_of_body(const Call& c) {
  return make_scene(plan_of(c, text_of(c.body, "text", longest_text)));
}

std::span<const Route> file_calls() {
  return of_files;
}

}  // namespace powbench::host
