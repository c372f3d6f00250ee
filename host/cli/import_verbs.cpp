#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/phase.h"
#include "core/version.h"
#include "dsp/events/switch_off.h"
#include "dsp/events/switch_on.h"
#include "host/cli/show.h"
#include "host/cli/verbs.h"
#include "host/compare/compare.h"
#include "host/config/bad_input.h"
#include "host/export/events_json.h"
#include "host/export/write_file.h"
#include "host/gather/event_filter.h"
#include "host/gather/scene.h"
#include "host/gather/vibration.h"
#include "host/import/foreign_table.h"
#include "host/import/suggest.h"
#include "host/import/waveform.h"
#include "host/store/hash.h"
#include "host/store/json.h"

namespace powbench::host {

namespace {

constexpr const char* imported_uri = "file:";

Imported read(const std::string& file, const std::string& calibration) {
  return import_file(file,
                     calibration.empty() ? std::nullopt : std::optional<std::filesystem::path>(calibration));
}

/// Where no closing angle was commanded, the one reached is taken for it, and without either there is none.
void take_angle(Imported& in, const Events& e) {
  if (!in.angle_commanded && e.coil.closing_angle.known())
    in.record.conditions.closing_angle = wrap_turn(e.coil.closing_angle.value);
}

/// Why the record shows no closing angle; "" when it does.
std::string no_angle_reason(const Imported& in, const Events& e) {
  if (e.coil.closing_angle.known()) return "";
  std::string missing;
  for (const Channel c : {Channel::mains_voltage, Channel::coil_voltage})
    if (in.record.find(c) == nullptr) missing += (missing.empty() ? "" : " and ") + std::string(info(c).name);
  const bool by_coil = in.record.find(Channel::coil_voltage) && !in.record.find(Channel::mains_voltage);
  return "closing angle not found: " +
         (by_coil           ? e.coil.no_angle
          : missing.empty() ? "no step of the coil voltage behind two periods of the mains"
                            : "the file has no " + missing) +
         (in.angle_commanded ? "; the commanded one stands for it"
                             : "; closing_angle_deg in the calibration file can give it");
}

/// What the record says against time 0 being the switch-on; "" when nothing.
std::string wrong_zero(const Imported& in, const Events& e) {
  if ((e.coil.flags & flag_switch_on) == 0) return "";
  const double at = dsp::contradicted_switch_on(in.record);
  return fmt::format(
      "time 0 is not the switch-on: the coil {} {}. {}; write switch_on_s, on the time column, into the "
      "calibration file",
      in.record.find(Channel::coil_voltage) ? "voltage begins" : "current begins",
      std::isfinite(at) ? fmt::format("at about {:.1f} ms", at * 1e3) : std::string("before the record"),
      e.coil.switch_on.known()
          ? "t_ct1, t_ct2, t_xt1 and t_xt2 count from its step, listed contacts from time 0"
          : "All times count from time 0, so they are wrong");
}

/// What a record without bounce time needs where it seems to go on behind a switch-off that no coil channel shows; ""
/// otherwise.
std::string wanted_hold(const Imported& in, const Events& e) {
  if (no_bounce_reason(e).empty() || std::isfinite(in.record.conditions.hold_time)) return "";
  const dsp::SeenReturn back = dsp::seen_return(in.record);
  if (!std::isfinite(back.at)) return "";
  return fmt::format(
      "{} goes back to its rest at {:.1f} ms: no settled touch. If the coil was switched off before, write "
      "hold_ms = {:.0f} "
      "into the calibration file",
      info(back.channel).name, back.at * 1e3, std::max(std::floor(back.at * 1e3), 1.0));
}

/// What stands for the plan of imported records: as far as it matters, what their calibration says.
Scene imported_scene(const Imported& in) {
  Scene scene;
  scene.plan.name = "imported";
  scene.plan.angles = {0.0};
  scene.plan.repeats = 1;
  scene.plan.order = Order::by_hand;
  scene.plan.test.recorded = in.recorded;
  scene.plan.test.source = in.source;
  if (!in.calibration.empty()) scene.plan.test.instruments.push_back(in.calibration);
  scene.plan.mains_hertz = in.options.mains_hertz;
  scene.plan.crosstalk_a = in.options.crosstalk_a;
  scene.plan.crosstalk_b = in.options.crosstalk_b;
  scene.specimen.name = in.record.conditions.specimen;
  scene.plan_text = resolved_text(scene.plan);
  scene.plan_hash = sha256_hex(scene.plan_text);
  scene.specimen_text = resolved_text(scene.specimen);
  scene.specimen_hash = sha256_hex(scene.specimen_text);
  return scene;
}

std::int64_t campaign_of(Store& store, const Scene& scene) {
  for (const CampaignInfo& c : store.campaigns())
    if (c.rig_uri == imported_uri && c.plan_hash == scene.plan_hash && c.specimen_hash == scene.specimen_hash)
      return c.id;
  CampaignInfo info = campaign_info(scene, "", "waveform files");
  info.rig_uri = imported_uri;
  info.origin = Origin::import;
  const std::int64_t id = store.create_campaign(info);
  store.set_finished(id, true);
  return id;
}

/// A number that is the same for the same samples, clock and calibration, so that a file is stored once.
std::uint64_t identity(const Record& r) {
  std::string text = fmt::format("{} {} {} {}", r.sample_rate, r.fire_sample, r.fire_offset, r.calibration);
  for (const ChannelRecord& c : r.channels) {
    text += fmt::format(" {} {} {} {} {}", info(c.channel).name, c.scale, c.offset, c.delay, c.corner_hertz);
    text.append(reinterpret_cast<const char*>(c.raw.data()), c.raw.size() * sizeof c.raw[0]);
  }
  return std::stoull(sha256_hex(text).substr(0, 13), nullptr, 16);
}

}  // namespace

namespace {

/// The calibration file that the columns suggest; the table of reasons is talk, or JSON.
Exit suggest(const ImportArgs& args) {
  if (!args.json) refuse_existing(args.output, args.overwrite);
  const CsvTable table = read_table(args.file);
  const Suggested s = suggest_columns(table);
  const std::string text = suggested_file(table, s, std::filesystem::path(args.file).filename().string());
  for (const std::string& note : table.notes) fmt::print(stderr, "{}: {}\n", args.file, note);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  if (!s.time.empty())
    fmt::print(stderr, "{:<24} {:<14} {}\n", s.time, "time", s.time_why);
  else
    fmt::print(stderr,
               "{}: no column is the time: [columns] time = \"NAME [s]\" names one, sample_rate_hertz stands "
               "for it\n",
               args.file);
  for (const Suggestion& c : s.columns) {
    const std::string channel = c.channel ? std::string(info(*c.channel).name) : "-";
    fmt::print(stderr, "{:<24} {:<14} by {:<6} {:<7} {}\n", table.header[c.column], channel,
               c.channel ? name(c.ground) : "-", c.channel ? name(c.sure) : "-", c.why);
    list.push_back(
        {{"column", table.header[c.column]},
         {"channel", c.channel ? nlohmann::ordered_json(channel) : nlohmann::ordered_json(nullptr)},
         {"ground", c.channel ? nlohmann::ordered_json(name(c.ground)) : nlohmann::ordered_json(nullptr)},
         {"sure", c.channel ? nlohmann::ordered_json(name(c.sure)) : nlohmann::ordered_json(nullptr)},
         {"why", c.why}});
  }
  if (args.json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"columns", list}, {"file", text}}.dump(2));
    return Exit::pass;
  }
  if (args.output.empty()) {
    fmt::print("{}", text);
    return Exit::pass;
  }
  write_file(args.output, text);
  fmt::print(stderr, "{}: check it, fill in the gains, then: powbench import {} --calibration {}\n",
             args.output, args.file, args.output);
  return Exit::pass;
}

}  // namespace

Exit import_waveform_file(const ImportArgs& args) {
  if (args.suggest) return suggest(args);
  Imported in = read(args.file, args.calibration);
  const Scene scene = imported_scene(in);
  RunOptions options = run_options(scene.plan);
  options.angle_tolerance = 0;  // nobody set one
  const Events events = extract_checked(in.record, options);
  take_angle(in, events);
  const std::string no_angle = no_angle_reason(in, events), wrong = wrong_zero(in, events),
                    hold = wanted_hold(in, events);
  Record& record = in.record;
  record.conditions.seed = identity(record);
  Store store(args.database);
  const std::int64_t campaign = campaign_of(store, scene);
  StoredShot shot;
  bool there = false;
  for (const StoredShot& s : store.shots(campaign, ShotKind::measured)) {
    if (s.conditions.seed == record.conditions.seed) shot.id = s.id, there = true;
    shot.number = std::max(shot.number, s.number + 1);
  }
  if (!there) {
    shot.campaign = campaign;
    shot.conditions = record.conditions;
    shot.angle_deg = stored_degrees(record.conditions.closing_angle);
    shot.outcome = Outcome::not_judged;
    shot.reason = wrong.empty() ? no_angle : wrong;
    shot.id = store.store_shot(shot, &record, &events, {dsp::to_text(options.extract), program_version});
  }
  for (const std::string& note : in.notes) fmt::print(stderr, "{}: {}\n", args.file, note);
  for (const std::string& text : {no_angle, wrong, hold})
    if (!text.empty()) fmt::print(stderr, "{}: {}\n", args.file, text);
  fmt::print(stderr, "{}: {} shot {} of {}; next: powbench events {} --db {}\n", args.file,
             there ? "is already" : "stored as", shot.id, args.database, shot.id, args.database);
  if (args.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"shot", shot.id},
                                              {"campaign", campaign},
                                              {"origin", name(Origin::import)},
                                              {"samples", record.samples()},
                                              {"sample_rate", record.sample_rate},
                                              {"notes", in.notes}}
                           .dump(2));
  else
    fmt::print("{}\n", shot.id);
  return Exit::pass;
}

Exit show_file_events(const EventsArgs& args) {
  Imported in = read(args.shot, args.calibration);
  const LabRule rule{args.force_percent, args.voltage_percent, args.min_opening_us};
  set_rule(in.options, rule);
  set_filter_options(in.options, args);
  if (args.stream) return stream_events(in.record, in.options, args);
  RunOptions run = run_options(Plan{});
  run.extract = in.options;
  FilteredEvents found = extract_filtered(in.record, run, false);
  Events& events = found.events;
  take_angle(in, events);
  write_strip(in.record, found, args,
              "waveform file " + std::filesystem::path(args.shot).filename().string());
  apply_rule(events, in.record, found.used, rule);
  for (const std::string& note : in.notes) fmt::print(stderr, "{}: {}\n", args.shot, note);
  for (const std::string& text : {wrong_zero(in, events), wanted_hold(in, events)})
    if (!text.empty()) fmt::print(stderr, "{}: {}\n", args.shot, text);
  if (args.json) {
    auto out = nlohmann::ordered_json::parse(to_events_json(events, in.record, 2, in.options));
    out["bands"] = nlohmann::ordered_json::parse(bands_json(in.record, events, found.bare, found.films));
    if (found.filter) out["filter"] = nlohmann::ordered_json::parse(filter_json(*found.filter));
    fmt::print("{}\n", out.dump(2));
    return Exit::pass;
  }
  fmt::print("{}, method {}\n", args.shot, events.method);
  if (in.angle_commanded)
    fmt::print("  closing angle of the calibration file: {:.2f} deg\n",
               degrees(in.record.conditions.closing_angle));
  print_events(events);
  print_bands(in.record, found);
  return Exit::pass;
}

}  // namespace powbench::host
