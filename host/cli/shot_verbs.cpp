#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/phase.h"
#include "core/quantities.h"
#include "host/cli/show.h"
#include "host/cli/verbs.h"
#include "host/compare/pair.h"
#include "host/export/write_file.h"
#include "host/gather/pair_json.h"
#include "host/gather/unlike.h"
#include "host/gather/verdict.h"
#include "host/report/number.h"
#include "host/store/json.h"
#include "rigs/sealed_shot.h"

/// Single shots, the test record, and two campaigns side by side.

namespace powbench::host {

namespace {

using Json = nlohmann::ordered_json;

/// "12.345 +- 0.004", in units of 1/scale of SI, to the digits of U = k u; a dash where it is not known.
std::string plain(const Measured& m, double scale, int decimals, double k = 2) {
  if (!m.known()) return "-";
  const double U = k * m.u * scale;
  const int digits = decimals_for(U, decimals);
  std::string text = digits_of(m.value * scale, digits);
  if (std::isfinite(U)) text += fmt::format(" +- {:.{}f}", U, digits);
  return text;
}

/// An angle of 0 .. 360 deg; what rounds to 360 is 0.
std::string angle_text(Measured m) {
  const std::string text = plain(m, degrees(1.0), 2);
  if (!text.starts_with("360")) return text;
  m.value -= 2 * pi;
  return plain(m, degrees(1.0), 2);
}

/// What the rig itself has sealed; nothing of a simulation, an import or a seal of an earlier firmware.
std::optional<rigs::SealedShot> sealed(const Store& store, const StoredShot& shot) {
  const std::string text = shot.record_hash.empty() ? std::string() : store.sealed_text(shot.id);
  if (text.empty()) return std::nullopt;
  try {
    return rigs::parse_sealed_shot(text);
  } catch (const rigs::SealError&) {
    return std::nullopt;
  }
}

std::string volts_and_hertz(const Conditions& c) {
  const auto text = [](double v, const char* unit, const char* what) {
    return std::isfinite(v) ? fmt::format("{:g} {}", v, unit) : fmt::format("{} not known", what);
  };
  return text(c.supply_volts, "V", "supply voltage") + ", " + text(c.mains_hertz, "Hz", "mains frequency");
}

std::string commanded(const StoredShot& s) {
  return std::isfinite(s.angle_deg) ? fmt::format("{:.2f}", s.angle_deg) : "-";
}

}  // namespace

Exit list_shots(const ResultArgs& args) {
  const Store store(args.database, Store::Mode::read_only);
  const CampaignInfo campaign = store.campaign(args.campaign);
  Json list = Json::array();
  if (!args.json)
    fmt::print("{}, campaign {}, {}; +- is U (k = 2)\n{:>6} {:<9} {:>7} {:>17} {:>17} {:>17} {:>17}  {}\n",
               name(campaign.origin), campaign.id, campaign.name, "shot", "", "deg", "reached deg",
               "touch ms", "bounce ms", "settled ms", "outcome");
  auto lines = store.lines(campaign.id);
  for (auto& [s, digested, reached, touch, bounce, settled] : lines) {
    // what a simulated time is uncertain by comes from its inputs, not from finding it in a clean record
    if (s.kind == ShotKind::simulated) {
      const auto u = store.prediction(s.id).u;
      touch.u = Shown::u_of(u, "t_ct1"), bounce.u = Shown::u_of(u, "t_ct_bon");
      settled.u = Shown::u_of(u, "t_ct2");
    }
    if (args.json) {
      list.push_back({{"shot", s.id},
                      {"campaign", s.campaign},
                      {"kind", name(s.kind)},
                      {"angle_deg", json_of<Json>(s.angle_deg)},
                      {"reached_rad", json_of<Json>(reached)},
                      {"touch_s", json_of<Json>(touch)},
                      {"bounce_s", json_of<Json>(bounce)},
                      {"settled_s", json_of<Json>(settled)},
                      {"attempt", s.attempt},
                      {"started", s.started},
                      {"outcome", name(s.outcome)},
                      {"reason", s.reason}});
      continue;
    }
    const auto time = [simulated = s.kind == ShotKind::simulated](const Measured& m) {
      return plain(m, 1e3, 3) + (simulated && m.known() && !std::isfinite(m.u) ? " +- ?" : "");
    };
    fmt::print("{:>6} {:<9} {:>7} {:>17} {:>17} {:>17} {:>17}  {}{}{}\n", s.id, name(s.kind), commanded(s),
               angle_text(reached), time(touch), time(bounce), time(settled), name(s.outcome),
               s.reason.empty() ? "" : ": ", s.reason);
  }
  if (args.json) fmt::print("{}\n", list.dump(2));
  if (args.json) return Exit::pass;
  for (const StoredShot& s : store.earlier_attempts(campaign.id))
    fmt::print("earlier: shot {}, {} deg, attempt {}, {}: {}{}{}\n", s.id, commanded(s), s.attempt, s.started,
               name(s.outcome), s.reason.empty() ? "" : ": ", s.reason);
  return Exit::pass;
}

/// A shot's number is its own in a store; a campaign beside it must be the shot's.
static StoredShot shot_of(const Store& store, const ShotArgs& args) {
  StoredShot s = store.shot(args.shot);
  if (args.campaign && *args.campaign != s.campaign)
    throw BadInput({fmt::format("--campaign {}: shot {} is of campaign {}; leave --campaign out",
                                *args.campaign, s.id, s.campaign)});
  return s;
}

Exit show_shot(const ShotArgs& args) {
  const Store store(args.database, Store::Mode::read_only);
  const StoredShot s = shot_of(store, args);
  const CampaignInfo campaign = store.campaign(s.campaign);
  const Shown stored(store, s);
  const auto& events = stored.events;
  const auto seal = sealed(store, s);
  const Origin origin = s.kind == ShotKind::simulated ? Origin::simulation : campaign.origin;
  if (args.json) {
    Json out = {{"shot", s.id},
                {"campaign", s.campaign},
                {"origin", name(origin)},
                {"kind", name(s.kind)},
                {"angle_deg", json_of<Json>(s.angle_deg)},
                {"supply_volts", json_of<Json>(s.conditions.supply_volts)},
                {"mains_hertz", json_of<Json>(s.conditions.mains_hertz)},
                {"hold_time_s", json_of<Json>(s.conditions.hold_time)},
                {"ambient_K", json_of<Json>(s.conditions.ambient)},
                {"seed", seed_of<Json>(origin, s.conditions)},
                {"started", s.started},
                {"attempt", s.attempt},
                {"outcome", name(s.outcome)},
                {"reason", s.reason},
                {"record_sha256", s.record_hash},
                {"sealed", seal ? Json(seal->text) : Json(nullptr)},
                {"quantities", stored.json<Json>()},
                {"u_of_events", u_of_events(s.kind)},
                {"events", events ? Json::parse(to_json(*events, 2)) : Json(nullptr)}};
    fmt::print("{}\n", out.dump(2));
    return Exit::pass;
  }
  const auto line = [](std::string_view key, const std::string& text) {
    if (!text.empty()) fmt::print("{:<12} {}\n", key, text);
  };
  fmt::print("{}, {} shot {} of campaign {}, {}\n", name(origin), name(s.kind), s.id, s.campaign,
             campaign.name);
  // an import was not commanded: its angle is one that the file gave, unless it is the one found
  const bool imported = origin == Origin::import;
  const bool found =
      imported && events && events->coil.closing_angle.known() &&
      std::fabs(wrap_half_turn(events->coil.closing_angle.value - s.conditions.closing_angle)) < 1e-9;
  line(imported ? "given" : "asked",
       fmt::format("{}, {}, {}, {}",
                   !found && std::isfinite(s.angle_deg) ? fmt::format("{:.2f} deg", s.angle_deg)
                   : found                              ? std::string("no closing angle")
                                                        : std::string("closing angle not known"),
                   volts_and_hertz(s.conditions),
                   std::isfinite(s.conditions.hold_time)
                       ? fmt::format("hold {:g} ms", s.conditions.hold_time * 1e3)
                       : std::string("hold not known"),
                   std::isfinite(s.conditions.ambient)
                       ? fmt::format("{:.1f} degC", s.conditions.ambient - zero_celsius)
                       : std::string("ambient not known")));
  if (events)
    line("reached", angle_text(events->coil.closing_angle) + " deg, " +
                        plain(events->coil.supply_volts, 1, 1) + " V, " +
                        plain(events->coil.mains_hertz, 1, 3) + " Hz");
  line("outcome", fmt::format("{}{}{}", name(s.outcome), s.reason.empty() ? "" : ": ", s.reason));
  line(imported ? "imported" : "begun", fmt::format("{}, attempt {}", s.started, s.attempt));
  if (seal) {
    line("rig",
         fmt::format("{} {}, boot {}, its shot {}", seal->model, seal->serial, seal->boot, seal->shot));
    line("firmware", fmt::format("{}, commit {}, image {:08x}, configuration {:08x}", seal->firmware,
                                 seal->commit, seal->image_crc32, seal->config_crc32));
    line("calibration", seal->calibration);
    if (seal->complete())
      line("phase", fmt::format("U {:.3f} deg (k = 2) at the edge, by the rig; asked for {:.3f}",
                                static_cast<double>(seal->angle_u_mdeg) * 2e-3,
                                static_cast<double>(seal->tolerance_mdeg) * 1e-3));
  }
  line("record", s.record_hash.empty() ? "none" : "sha256 " + s.record_hash);
  if (events)
    print_events(*events,
                 s.kind == ShotKind::simulated
                     ? " of what its inputs leave open; at each contact, of how well "
                       "its curve can be read"
                     : "",
                 &stored);
  fmt::print(stderr, "powbench events {0} extracts them anew, powbench plot {0} draws the channels\n", s.id);
  return Exit::pass;
}

Exit plot_shot(const ShotArgs& args) {
  const std::string file = args.file.empty() ? fmt::format("shot-{}.svg", args.shot) : args.file;
  const std::string kind = std::filesystem::path(file).extension().string();
  if (kind != ".svg" && kind != ".html")
    throw BadInput({fmt::format("-o {}: a picture is .svg or .html", file)});
  const Store store(args.database, Store::Mode::read_only);
  const ReportInput input = gather_shot(store, shot_of(store, args).id);
  write_file(file, kind == ".svg" ? render_shot_svg(input) : render_shot_html(input));
  if (args.json) fmt::print("{}\n", Json{{"picture", file}, {"shot", args.shot}}.dump(2));
  fmt::print(stderr, "{}\n", file);
  return Exit::pass;
}

Exit annotate(const AnnotateArgs& args) {
  if (args.key.empty()) {
    const Store store(args.database, Store::Mode::read_only);
    const CampaignInfo campaign = store.campaign(args.campaign);
    Json list = Json::array();
    for (const Annotation& a : store.annotations(campaign.id)) {
      if (args.json)
        list.push_back({{"created", a.created}, {"key", a.key}, {"text", a.text}});
      else
        fmt::print("{}  {:<11} {}\n", a.created, a.key, a.text);
    }
    if (args.json) fmt::print("{}\n", list.dump(2));
    return Exit::pass;
  }
  TestRecord added;
  complete(added, args.key, args.text);  // refuses what no report could read, before a file is opened
  if (!std::filesystem::exists(args.database)) Store(args.database, Store::Mode::read_only);  // says so
  Store store(args.database, Store::Mode::read_write);
  const CampaignInfo campaign = store.campaign(args.campaign);
  refuse_line(args.key, args.text, campaign.origin == Origin::import);
  store.annotate(campaign.id, args.key, args.text);
  const std::string begun = campaign.created.substr(0, 10);
  if (campaign.origin != Origin::import)  // when those were recorded, another line of the record says
    for (const Instrument& i : expired(added, begun))
      fmt::print(
          stderr,
          "calibration expired: {}, certificate {}, was valid until {}, the test began on {}; the report "
          "says so on page 1\n",
          i.name, i.certificate, i.valid_until, begun);
  fmt::print(stderr, "campaign {}, {}: {} added; what was fired and recorded is unchanged\n", campaign.id,
             campaign.name, args.key);
  return Exit::pass;
}

Exit compare_campaigns(const CompareArgs& args) {
  if (args.pair.empty()) return compare_campaign(args);
  if (args.campaign) throw BadInput({"--campaign: allowed only without two campaigns to compare"});
  const Store store(args.database, Store::Mode::read_only);
  const CampaignInfo first = store.campaign(args.pair[0]), second = store.campaign(args.pair[1]);
  const auto rows = compare_pair(compare_stored(store, first), compare_stored(store, second));
  const Outcome verdicts[] = {campaign_verdict(store, first), campaign_verdict(store, second)};
  if (args.json) {
    fmt::print("{}\n", pair_json(rows, 2));
    return exit_of(worse(verdicts[0], verdicts[1]));
  }
  std::size_t differ = 0, judged = 0;
  fmt::print(
      "campaign {}, {} ({}, {}), against campaign {}, {} ({}, {}); +- is U, 95.45 % (k = 2 and more)\n"
      "{:<9} {:>7} {:>7} {:>19} {:>19} {:>11} {:>9} {:>7}\n",
      second.id, second.name, name(second.origin), name(verdicts[1]), first.id, first.name,
      name(first.origin), name(verdicts[0]), "quantity", "deg", "n", "first", "second", "difference", "U",
      "diff./U");
  for (const PairRow& r : rows) {
    const ReadableUnit unit = readable_unit(r.unit);
    const int digits = decimals_for(r.U * unit.per_si, 3);
    fmt::print("{:<9} {:>7} {:>7} {:>19} {:>19} {:>11} {:>9} {:>7} {:<9} {}\n", r.quantity,
               std::isfinite(r.closing_angle) ? fmt::format("{:.2f}", degrees(r.closing_angle)) : "-",
               fmt::format("{}, {}", r.n[0], r.n[1]), plain(r.first, unit.per_si, 3, r.k[0]),
               plain(r.second, unit.per_si, 3, r.k[1]), digits_of(r.difference * unit.per_si, digits),
               digits_of(r.U * unit.per_si, digits), digits_of(r.over_U(), 2), agreement(r.over_U()),
               unit.name);
    judged += std::isfinite(r.over_U()) ? 1U : 0U;
    differ += r.over_U() > 1 ? 1U : 0U;
  }
  fmt::print("{} of {} differ, {} not known\n", differ, judged, rows.size() - judged);
  const auto lines = unlike(store, first, second);
  if (!lines.empty()) fmt::print("the two campaigns were not alike in\n");
  for (const std::string& line : lines) fmt::print("  {}\n", line);
  if (const std::string same = same_records_sentence(store, first, second); !same.empty())
    fmt::print("{}\n", same);
  return exit_of(worse(verdicts[0], verdicts[1]));
}

}  // namespace powbench::host
