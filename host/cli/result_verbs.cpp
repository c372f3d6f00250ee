#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/counted.h"
#include "dsp/events/coil.h"
#include "dsp/events/core_seat.h"
#include "dsp/events/extract.h"
#include "host/cli/show.h"
#include "host/cli/verbs.h"
#include "host/config/filter_text.h"
#include "host/export/events_json.h"
#include "host/export/write_file.h"
#include "host/gather/event_filter.h"
#include "host/gather/gather.h"
#include "host/gather/pdf.h"
#include "host/gather/scene.h"
#include "host/gather/strip_picture.h"
#include "host/gather/summary_json.h"
#include "host/gather/verdict.h"
#include "host/gather/vibration.h"
#include "host/report/number.h"
#include "host/store/json.h"

namespace powbench::host {

namespace {

using Json = nlohmann::ordered_json;

/// Value in the unit people read, or a dash.
std::string shown(double si, const std::string& unit) {
  return digits_of(si * readable_unit(unit).per_si, 3);
}

/// The same to the digits of its U, where that is known.
std::string shown(double si, const std::string& unit, double U) {
  const ReadableUnit readable = readable_unit(unit);
  return digits_of(si * readable.per_si, decimals_for(U * readable.per_si, 3));
}

std::string shown_unit(const std::string& unit) {
  return unit == "s" ? "ms" : unit == "m" ? "mm" : unit == "A" ? "mA" : unit;
}

std::string degrees_text(double angle) {
  return std::isfinite(angle) ? fmt::format("{:.1f}", degrees(angle)) : "-";
}

Json row_json(const ComparisonRow& r) {
  return {{"quantity", r.quantity},
          {"unit", r.unit},
          {"closing_angle_deg", json_of<Json>(stored_degrees(r.closing_angle))},
          {"repeats", r.repeats},
          {"measured", json_of<Json>(r.measured.value)},
          {"u_measured", json_of<Json>(r.measured.u)},
          {"U_measured", json_of<Json>(r.coverage * r.measured.u)},
          {"k", json_of<Json>(r.coverage)},
          {"scatter", json_of<Json>(r.scatter)},
          {"scatter_to_simulated", json_of<Json>(r.unexplained)},
          {"simulated", json_of<Json>(r.simulated)},
          {"published_measurement", json_of<Json>(r.published_measurement)},
          {"published_simulation", json_of<Json>(r.published_simulation)},
          {"u_simulated", json_of<Json>(r.u_simulated)},
          {"difference_over_U", json_of<Json>(r.difference_over_U())},
          {"agreement", agreement(r.difference_over_U())},
          {"against_simulation", name(r.against_simulation)},
          {"outcome", name(r.outcome)}};
}

Json curve_json(const CurveRow& r) {
  const CurveDeviation& d = r.median;
  return {{"quantity", r.quantity},
          {"unit", r.unit},
          {"closing_angle_deg", json_of<Json>(stored_degrees(r.closing_angle))},
          {"repeats", r.repeats},
          {"measured", json_of<Json>(d.measured)},
          {"simulated", json_of<Json>(d.simulated)},
          {"largest_difference", json_of<Json>(d.largest)},
          {"at_s", json_of<Json>(d.at)},
          {"relative_percent", json_of<Json>(d.share() * 100)},
          {"rms_percent_of_span", json_of<Json>(d.rms_share * 100)},
          {"late_s", json_of<Json>(d.late)}};
}

void print_curves(const std::vector<CurveRow>& rows) {
  if (rows.empty()) return;
  fmt::print(
      "\nlargest difference of the curves, switch-on to 2 ms after the last landing, means over 0.1 ms; "
      "median shot\n"
      "{:<9} {:>7}  {:>3} {:>10} {:>8} {:>10} {:>10} {:>8} {:>8} {:>8}\n",
      "curve", "deg", "n", "largest", "at ms", "measured", "simulated", "%", "rms %", "late ms");
  for (const CurveRow& r : rows) {
    const CurveDeviation& d = r.median;
    fmt::print("{:<9} {:>7}  {:>3} {:>10} {:>8.1f} {:>10} {:>10} {:>8.1f} {:>8.2f} {:>8.3f} {}\n", r.quantity,
               degrees_text(r.closing_angle), r.repeats, shown(d.largest, r.unit), d.at * 1e3,
               shown(d.measured, r.unit), shown(d.simulated, r.unit), d.share() * 100, d.rms_share * 100,
               d.late * 1e3, shown_unit(r.unit));
  }
  fmt::print(
      "%: of the measured value there; rms %: of the measured span; late: how far the simulated curve is "
      "behind\n");
}

}  // namespace

Exit list_campaigns(const ResultArgs& args) {
  const Store store(args.database, Store::Mode::read_only);
  Json list = Json::array();
  for (const CampaignInfo& c : store.campaigns()) {
    if (args.campaign && c.id != *args.campaign) continue;
    if (!args.json) {
      const auto count = [&](ShotKind kind) {
        std::size_t n = 0;
        for (const auto& [outcome, shots] : store.outcomes(c.id, kind)) n += shots;
        return n;
      };
      fmt::print("{:>4}  {}  {:<15}  {:<20} {:>11}, {:>4} simulated  {}\n", c.id, c.created, name(c.origin),
                 c.name, counted(count(ShotKind::measured), "shot"), count(ShotKind::simulated),
                 c.finished ? "finished" : "unfinished");
      continue;
    }
    const auto measured = store.shots(c.id, ShotKind::measured);
    const auto simulated = store.shots(c.id, ShotKind::simulated);
    Json shots = Json::array();
    for (const auto* kind : {&measured, &simulated})
      for (const StoredShot& s : *kind)
        shots.push_back({{"id", s.id},
                         {"kind", name(s.kind)},
                         {"number", s.number},
                         {"angle_deg", json_of<Json>(s.angle_deg)},
                         {"outcome", name(s.outcome)},
                         {"reason", s.reason},
                         {"seed", seed_of<Json>(c.origin, s.conditions)},
                         {"record_sha256", s.record_hash}});
    Json earlier = Json::array();
    for (const StoredShot& s : store.earlier_attempts(c.id))
      earlier.push_back({{"number", s.number},
                         {"attempt", s.attempt},
                         {"started", s.started},
                         {"outcome", name(s.outcome)},
                         {"reason", s.reason}});
    list.push_back({{"id", c.id},
                    {"created", c.created},
                    {"name", c.name},
                    {"origin", name(c.origin)},
                    {"plan_hash", c.plan_hash},
                    {"rig", c.rig_identity},
                    {"finished", c.finished},
                    {"shots", shots},
                    {"earlier_attempts", earlier}});
  }
  if (args.json) fmt::print("{}\n", list.dump(2));
  return Exit::pass;
}

namespace {

/// Microseconds with two significant digits (three from 100 us on), or a dash.
std::string micro(double s) {
  const double us = s * 1e6;
  if (!std::isfinite(us)) return "-";
  return fmt::format("{:.{}f}", us, us >= 9.95 ? 0 : us >= 0.995 ? 1 : 2);
}

/// Per cent that a contact is one of its own; never 100 for what is not certain.
std::string probability(double p) {
  return p >= 1 ? "100 %" : p > 0.99 ? ">99 %" : p < 0.01 ? "<1 %" : fmt::format("{:.0f} %", 100 * p);
}

void print_train(const char* title, const ContactTrain& train) {
  if (!train.present) return;
  if (train.shows != Shows::contact) {
    fmt::print("  {}: shows {}: {}\n", title, name(train.shows), train.reason);
    return;
  }
  fmt::print("  {}: {}, resolves {:.0f} us{}\n", title,
             counted(static_cast<std::size_t>(train.bounce_count), "re-opening"), train.resolution * 1e6,
             train.flags ? " [" + flag_names(train.flags) + "]" : "");
  const std::pair<const char*, const BounceTrain*> parts[] = {{"first train", &train.first_train},
                                                              {"second train", &train.second_train}};
  for (const auto& [name, part] : parts)
    if (part->from.known())
      fmt::print("    {}: {}, {} .. {} ms\n", name,
                 counted(static_cast<std::size_t>(part->openings), "re-opening"),
                 shown(part->from.value, "s"), shown(part->to.value, "s"));
  for (const Contact& c : train.contacts)
    fmt::print("    touch {:>9} ms +- {:>4} us  release {:>9} ms +- {:>4} us  peak {:>8} N  real {:>5}  {}\n",
               shown(c.touch.value, "s"), micro(2 * c.touch.u), shown(c.release.value, "s"),
               micro(2 * c.release.u), shown(c.peak.value, "N"), probability(c.probability),
               flag_names(c.flags));
}

}  // namespace

std::string digits_of(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  const double one = std::pow(10.0, decimals);
  return fmt::format("{:.{}f}", std::round(value * one) / one + 0.0, decimals);
}

std::string no_bounce_reason(const Events& events) {
  const ContactTrain& t = timing_train(events);
  if (t.bounce_time.known()) return "";
  if (!t.present) return "no channel shows the contact";
  if (t.shows != Shows::contact) return fmt::format("the channel shows {}", name(t.shows));
  if (t.contacts.empty())
    return "the contact does not touch before the coil is switched off, or the record ends";
  if (t.flags & flag_chatter)
    return "the closing is seen for too short a time behind the last touch, or the core still moves";
  if (t.flags & flag_gap) return "lost samples may hide an opening behind the last touch seen";
  if (const Measured& last = t.contacts.back().release; last.known())
    return fmt::format("the contact opens at {:.1f} ms and stays open: no settled touch", last.value * 1e3);
  return "no settled touch";
}

void print_events(const Events& events, std::string_view u_of, const Shown* stored) {
  fmt::print("  +- is U (k = 2){}\n", u_of);
  for (const Quantity& q : quantity_table) {
    const Measured m = stored ? stored->of(q) : q.of(events);
    const std::string unit(q.unit);
    const bool time = unit == "s";  // in ms the uncertainty of a time would read zero
    fmt::print("  {:<9} {:>10} {:<3} +- {:<6} {:<3} {}\n", q.symbol, shown(m.value, unit, 2 * m.u),
               shown_unit(unit), time ? micro(2 * m.u) : shown(2 * m.u, unit, 2 * m.u),
               time ? "us" : shown_unit(unit), q.meaning);
  }
  // of the hum each film says itself whether it was removed; of the supply, the closing angle's line does
  constexpr std::uint32_t of_record =
      flag_no_calibration | flag_angle_off | flag_switch_on | flag_beyond_fields;
  if (const std::uint32_t flags = events.flags & of_record; flags != 0)
    fmt::print("  record [{}]\n", flag_names(flags));
  if (!events.coil.no_angle.empty()) fmt::print("  no closing angle: {}\n", events.coil.no_angle);
  if (dsp::angle_by_coil(events.coil))
    fmt::print(
        "  closing angle {:.3f} deg +- {:.3f} deg, from the coil voltage after switch-on: no mains-voltage "
        "channel\n",
        degrees(events.coil.closing_angle.value), 2 * degrees(events.coil.closing_angle.u));
  if (const std::string reason = no_bounce_reason(events); !reason.empty())
    fmt::print("  no bounce time: {}\n", reason);
  print_train("contact voltage", events.contact_voltage);
  print_train("film A", events.pvdf_a);
  print_train("film B", events.pvdf_b);
  print_train("pole by force", events.pole.by_force);
  if (events.core.seat.known())
    fmt::print("  core: a second landing within {:.0f} us of the first is not told apart{}\n",
               1e6 * dsp::core_resolution({}),
               events.core.flags ? " [" + flag_names(events.core.flags) + "]" : "");
  const PoleEvents& p = events.pole;
  if (p.disagreement.known())
    fmt::print("  force and contact voltage differ for {} us +- {}, at most {} us +- {} at a time\n",
               micro(p.disagreement.value), micro(2 * p.disagreement.u), micro(p.longest_disagreement.value),
               micro(2 * p.longest_disagreement.u));
}

void set_filter_options(dsp::ExtractOptions& o, const EventsArgs& args) {
  const FilterMistake m = set_filter(o, {args.filter, args.phase, args.band});
  if (!m.key.empty()) throw BadInput({fmt::format("--{}: {}; allowed {}", m.key, m.what, m.allowed)});
}

void write_strip(const Record& record, const FilteredEvents& found, const EventsArgs& args,
                 const std::string& origin) {
  if (args.picture.empty()) return;
  if (!args.picture.ends_with(".svg"))
    throw BadInput({fmt::format("--picture {}: a picture is .svg", args.picture)});
  write_file(args.picture, strip_svg(record, found, origin + ", " + found.events.method));
  fmt::print(stderr, "{}\n", args.picture);
}

void print_bands(const Record& record, const FilteredEvents& found) {
  if (found.filter)
    for (const std::string& line : filter_lines(*found.filter)) fmt::print("  {}\n", line);
  for (const std::string& line : band_lines(record, found.events, found.bare, found.films))
    fmt::print("  {}\n", line);
}

Exit show_events(const EventsArgs& args) {
  std::int64_t id = 0;
  const char* const end = args.shot.data() + args.shot.size();
  const auto [rest, error] = std::from_chars(args.shot.data(), end, id);
  if (error != std::errc() || rest != end) return show_file_events(args);
  const Store store(args.database, Store::Mode::read_only);
  const StoredShot shot = store.shot(id);
  if (args.campaign && *args.campaign != shot.campaign)
    throw BadInput({fmt::format("--campaign {}: shot {} is of campaign {}; leave --campaign out",
                                *args.campaign, id, shot.campaign)});
  const CampaignInfo campaign = store.campaign(shot.campaign);
  RunOptions options = stored_options(campaign, stored_plan(campaign));
  const LabRule rule{args.force_percent, args.voltage_percent, args.min_opening_us};
  set_rule(options.extract, rule);
  set_filter_options(options.extract, args);
  Record record = store.load_record(id);
  record.conditions = shot.conditions;
  if (args.stream) return stream_events(record, options.extract, args);
  FilteredEvents found = extract_filtered(record, options, args.filter.empty());
  Events& events = found.events;
  write_strip(record, found, args,
              fmt::format("{}, {} shot {}", name(campaign.origin), name(shot.kind), shot.id));
  apply_rule(events, record, found.used, rule);
  if (args.json) {
    Json out = Json::parse(to_json(events, 2));
    // What a file's result has under these keys stands here too; `core` alone differs, as the store has it.
    Json agreed = Json::parse(to_events_json(events, record, 2, options.extract));
    for (const char* key : {"channels", "closing_angle_deg", "u_closing_angle_deg"}) out[key] = agreed[key];
    out["u_of_events"] = u_of_events(shot.kind);
    out["bands"] = Json::parse(bands_json(record, events, found.bare, found.films));
    if (found.filter) out["filter"] = Json::parse(filter_json(*found.filter));
    fmt::print("{}\n", out.dump(2));
    return Exit::pass;
  }
  fmt::print("{}, {} shot {}, {}, method {}\n", name(campaign.origin), name(shot.kind), shot.id,
             std::isfinite(shot.angle_deg) ? fmt::format("closing angle {:.2f} deg", shot.angle_deg)
                                           : std::string("closing angle not known"),
             events.method);
  print_events(events, shot.kind == ShotKind::simulated
                           ? fmt::format(" of how well its curve can be read; what its inputs leave open: "
                                         "powbench show {}",
                                         shot.id)
                           : "");
  print_bands(record, found);
  return Exit::pass;
}

Exit compare_campaign(const ResultArgs& args) {
  const Store store(args.database, Store::Mode::read_only);
  const CampaignInfo campaign = store.campaign(args.campaign);
  const Comparison comparison = compare_stored(store, campaign);
  const std::vector<CurveRow> curves = gather_curves(store, campaign);
  Json list = Json::array();
  if (!args.json)
    fmt::print(
        "{}, campaign {}, {}; U covers 95.45 % (k = 2 and more); diff./U over both U\n{:<9} {:>7}  {:>3} "
        "{:>10} {:>8} {:>8} {:>8} "
        "{:>10} {:>8} "
        "{:>7} {:<9} {:>4} {}\n",
        name(campaign.origin), campaign.id, campaign.name, "quantity", "deg", "n", "measured", "U", "scatter",
        "to sim.", "simulated", "U sim.", "diff./U", "", "", "limits");
  for (const ComparisonRow& r : comparison.rows) {
    if (args.json) {
      list.push_back(row_json(r));
      continue;
    }
    const double E = r.difference_over_U(), U = r.coverage * r.measured.u;
    const double U_simulated = std::isfinite(r.u_simulated) ? 2 * r.u_simulated : U;
    fmt::print("{:<9} {:>7}  {:>3} {:>10} {:>8} {:>8} {:>8} {:>10} {:>8} {:>7} {:<9} {:>4} {}{}\n",
               r.quantity, degrees_text(r.closing_angle), r.repeats, shown(r.measured.value, r.unit, U),
               shown(U, r.unit, U), shown(r.scatter, r.unit, U), shown(r.unexplained, r.unit, U),
               shown(r.simulated, r.unit, U_simulated), shown(2 * r.u_simulated, r.unit, U_simulated),
               std::isfinite(E) ? fmt::format("{:.2f}", E) : "-",
               std::isfinite(r.simulated) ? agreement(E) : "", shown_unit(r.unit), name(r.outcome),
               r.against_simulation == Outcome::fail ? ", FAIL against the simulation" : "");
  }
  if (args.json) {
    for (const CurveRow& r : curves) list.push_back(curve_json(r));
    fmt::print("{}\n", list.dump(2));
  } else {
    print_curves(curves);
  }
  return exit_of(campaign_verdict(store, campaign));
}

Exit write_report(const ReportArgs& args) {
  const Store store(args.database, Store::Mode::read_only);
  const CampaignInfo campaign = store.campaign(args.campaign);
  const ReportInput input = gather_report(store, campaign, args.database);
  std::error_code error;
  std::filesystem::create_directories(args.folder, error);
  const std::filesystem::path folder(args.folder);
  write_file(folder / "report.html", render_html(input));
  write_file(folder / "junit.xml", render_junit(input));
  if (args.pdf) print_pdf(folder / "report.html", folder / "report.pdf");
  const Outcome outcome = verdict(input);
  const std::string html = (folder / "report.html").string(), junit = (folder / "junit.xml").string(),
                    pdf = args.pdf ? (folder / "report.pdf").string() : "";
  if (args.json) {
    Json out = {{"report", html}, {"junit", junit}, {"pdf", args.pdf ? Json(pdf) : Json(nullptr)}};
    out.update(Json::parse(summary_json(input)));
    fmt::print("{}\n", out.dump(2));
  }
  fmt::print(stderr, "{}, {}: {}; {}{}{} and {}\n", campaign.name, name(campaign.origin), name(outcome), html,
             args.pdf ? ", " : "", pdf, junit);
  return exit_of(outcome);
}

}  // namespace powbench::host
