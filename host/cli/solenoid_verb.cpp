#include "host/cli/solenoid_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "host/cli/named_steel.h"
#include "host/cli/percent.h"
#include "host/cli/solenoid_output.h"
#include "host/cli/table_files.h"
#include "host/cli/table_text.h"
#include "host/cli/threads.h"
#include "host/config/rig_file.h"
#include "host/config/solenoid_file.h"
#include "host/export/field_svg.h"
#include "host/export/field_vtu.h"
#include "host/export/write_file.h"
#include "host/store/field_table.h"
#include "sim/models/solenoid/solenoid_closing.h"
#include "sim/models/solenoid/solenoid_eddy_closing.h"
#include "sim/models/solenoid/solenoid_live.h"

namespace powbench::host {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr double default_volts = 24, mesh_share = 0.4;

/// Runs what may refuse the user's numbers.
template <class Call>
auto told(const std::string& file, const Call& call) {
  try {
    return call();
  } catch (const std::invalid_argument& e) {
    throw BadInput({file + ": " + e.what()});
  }
}

double in_range(const char* option, const std::optional<double>& given, double otherwise, double low,
                double high, const char* unit) {
  const double value = given.value_or(otherwise);
  if (value >= low && value <= high) return value;
  throw BadInput({fmt::format("{} = {:g}, allowed {:g} .. {:g} {}", option, value, low, high, unit)});
}

/// Options of `sim` that belong to plans of contactors.
void refuse_plan_options(const SimArgs& a) {
  const SimArgs plain;
  std::string wrong;
  if (!a.mechanics.empty()) wrong = "--mechanics = " + a.mechanics;
  if (a.nominal) wrong = "--nominal";
  if (!a.shards.database.empty() || !a.shards.shard.empty() || a.shards.slurm > 0)
    wrong = "--points-db, --shard and --slurm";
  if (a.database != plain.database) wrong = "--db = " + a.database;
  if (!wrong.empty())
    throw BadInput(
        {wrong + ": not of a solenoid, which has no plan, no contacts and no store; leave it out"});
}

sim::SolenoidCase case_of(const SimArgs& args) {
  sim::SolenoidCase c;
  if (args.rig_file.empty()) {
    c.supply.mains.kind = sim::Mains::Kind::dc;
    c.supply.suppression.kind = sim::Suppression::Kind::diode;
  } else {
    c.supply = read_rig(args.rig_file).config.supply;
    if (c.supply.mains.kind == sim::Mains::Kind::ac)
      throw BadInput({args.rig_file + ": [supply] kind = ac, which a rig has unless told otherwise; allowed "
                                      "dc, half_wave, full_wave for a "
                                      "solenoid, whose iron is solid"});
  }
  c.supply.mains.volts = in_range("--volts", args.volts, default_volts, 0.1, 1e4, "V");
  c.supply.mains.hertz = in_range("--hertz", args.hertz, 50, 1, 1000, "Hz");
  c.coil_kelvin = in_range("--coil", args.coil_degC, 20, -60, 250, "degC") + zero_celsius;
  c.duration = in_range("--duration", args.duration_ms, 100, 1, 5000, "ms") * 1e-3;
  if (args.hold_ms) c.hold = in_range("--hold", args.hold_ms, 0, 0.1, c.duration * 1e3, "ms") * 1e-3;
  c.sample_step = std::min(50e-6, c.duration / 200);
  return c;
}

struct Simulated {
  sim::SolenoidRun run;
  std::string fields;    ///< what they were, for people
  bool plastic = false;  ///< impacts without rebound
};

Simulated run_with(const std::string& fields, const SimArgs& args, const sim::SolenoidSpecimen& s,
                   sim::SolenoidCase c) {
  const double accuracy =
      share_option("--accuracy", args.accuracy.empty() ? "0.5%" : args.accuracy, 5e-4, 0.05, "0.05% .. 5%");
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(accuracy);
  if (fields == "table") {
    if (s.design.remanence != 0)
      throw BadInput({"--fields = table: allowed solved or eddy with a permanent magnet, remanence_T not 0"});
    sim::TableOptions t;
    t.accuracy = accuracy;
    sim::Team team(2);
    const auto choice = obtain_field_table(args.cache, s.design, t, team);
    fmt::print(stderr, "{} ({})\n", choice.file.string(), choice.reused ? "as stored" : "built");
    const sim::TablePotential table(choice.table);
    return {sim::simulate_solenoid(s, table, c), choice.table.description};
  }
  if (fields == "solved") {
    c.tolerance = 1e-6;  // the field's own differences from gap to gap are no finer
    const sim::LiveSolenoid live(s.design, o);
    return {sim::simulate_solenoid(s, live, c),
            fmt::format("finite elements in the loop, {} unknowns", live.unknowns())};
  }
  if (fields == "eddy")
    return {sim::simulate_solenoid_eddies(s, o, c),
            fmt::format("finite elements in the loop, eddy currents at {:.3g} MS/m", s.conductivity * 1e-6),
            true};
  throw BadInput({"--fields = " + fields + ", allowed table, solved, eddy for a solenoid"});
}

std::string ms(const std::optional<double>& seconds) {
  return seconds ? fmt::format("{:.3f} ms", *seconds * 1e3) : "-";
}

std::string title_of(const sim::SolenoidSpecimen& s, const sim::SolenoidCase& c) {
  constexpr std::array<const char*, 4> kinds{"ac", "dc", "half wave", "full wave"};
  return fmt::format("{}: {:g} V {}, coil {:.3g} degC", s.name, c.supply.mains.volts,
                     kinds[static_cast<std::size_t>(c.supply.mains.kind)], c.coil_kelvin - zero_celsius);
}

std::vector<TimeMark> marks_of(const sim::SolenoidTruth& t, double off) {
  std::vector<TimeMark> out;
  const auto mark = [&](const std::optional<double>& time, const char* name) {
    if (time) out.push_back({*time, name});
  };
  mark(t.seat, "pull-in");
  if (std::isfinite(off)) out.push_back({off, "off"});
  mark(t.unseat, "leaves the stop");
  mark(t.back, "open");
  return out;
}

std::string text_of(const sim::SolenoidSpecimen& s, const sim::SolenoidCase& c, const Simulated& r) {
  const auto& t = r.run.truth;
  std::string out = title_of(s, c) + "\n  " + r.fields + "\n";
  out += fmt::format("  starts to move  {}\n", ms(t.start));
  out += t.seat ? fmt::format("  pull-in         {}, {:.3f} m/s\n", ms(t.seat), t.seat_velocity)
                : std::string("  pull-in         does not close\n");
  out +=
      fmt::format("  settled         {}{}\n", ms(t.settled), r.plastic ? " (impacts without rebound)" : "");
  if (t.peak_at)
    out += fmt::format("  current         {:.4f} A at {}, dip to {:.4f} A at {}\n", t.peak_current,
                       ms(t.peak_at), t.dip_current, ms(t.dip_at));
  out += fmt::format("  last current    {:.4f} A\n", t.last_current);
  for (const auto& e : r.run.events)
    if (e.kind == sim::SolenoidEvent::Kind::tap)
      out += fmt::format("  windings change over at {}\n", ms(e.time));
  if (std::isfinite(c.hold)) {
    const auto later = [&](const std::optional<double>& time) {
      return time ? ms(*time - c.hold) + " later"
                  : fmt::format("not within --duration {:g}", c.duration * 1e3);
    };
    out += t.settled ? fmt::format("  off at {}: leaves the stop {}, open {}\n", ms(c.hold), later(t.unseat),
                                   later(t.back))
                     : fmt::format("  off at {}: not closed then\n", ms(c.hold));
  }
  out += fmt::format("  energy balance  {:.1e} of {:.4f} J\n", r.run.energy_residual, r.run.supplied);
  if (r.run.beyond > 0)
    out += fmt::format("  {:.2g} % of the states lie outside of the table and are extrapolated\n",
                       100.0 * static_cast<double>(r.run.beyond) / static_cast<double>(r.run.states));
  return out;
}

Json json_of(const sim::SolenoidRun& r, const std::string& fields) {
  const auto time = [](const std::optional<double>& t) { return t ? Json(*t) : Json(); };
  const auto& t = r.truth;
  return {{"fields", fields},
          {"start_s", time(t.start)},
          {"pull_in_s", time(t.seat)},
          {"pull_in_speed_m_per_s", t.seat ? Json(t.seat_velocity) : Json()},
          {"settled_s", time(t.settled)},
          {"peak_current_A", t.peak_at ? Json(t.peak_current) : Json()},
          {"peak_at_s", time(t.peak_at)},
          {"dip_current_A", t.dip_at ? Json(t.dip_current) : Json()},
          {"dip_at_s", time(t.dip_at)},
          {"last_current_A", t.last_current},
          {"leaves_stop_s", time(t.unseat)},
          {"open_s", time(t.back)},
          {"energy_residual", r.energy_residual},
          {"supplied_J", r.supplied},
          {"states_beyond_fields",
           r.states > 0 ? static_cast<double>(r.beyond) / static_cast<double>(r.states) : 0}};
}

}  // namespace

void refuse_solenoid_options(const SimArgs& a) {
  if (a.volts || a.hertz || a.coil_degC || a.hold_ms || a.duration_ms || !a.output.empty())
    throw BadInput({a.plan +
                    ": --volts, --hertz, --coil, --hold, --duration and --output are those of a solenoid; "
                    "conditions of a contactor stand in its plan"});
}

Exit simulate_solenoid(const SimArgs& args) {
  refuse_plan_options(args);
  const auto s = read_solenoid(args.plan);
  const auto c = case_of(args);
  std::string fields = args.fields;
  if (fields.empty() || fields == "auto") fields = s.design.remanence != 0 ? "solved" : "table";
  const auto r = told(args.plan, [&] { return run_with(fields, args, s, c); });
  if (!args.output.empty()) {
    const bool csv = args.output.ends_with(".csv");
    if (!csv && !args.output.ends_with(".svg"))
      throw BadInput({"--output = " + args.output + ", allowed NAME.csv or NAME.svg"});
    write_file(args.output, csv ? solenoid_csv(r.run.samples)
                                : solenoid_svg(r.run.samples, marks_of(r.run.truth, c.hold), title_of(s, c)));
  }
  if (args.json)
    fmt::print("{}\n", json_of(r.run, r.fields).dump(2));
  else
    fmt::print("{}", text_of(s, c, r));
  return Exit::pass;
}

Exit show_solenoid_field(const FieldArgs& args) {
  if (args.ring || args.ends || args.symmetric || !args.mesh_file.empty())
    throw BadInput(
        {"--ring, --ends, --symmetric, --mesh: not of a solenoid, which is round and has no ring"});
  auto s = read_solenoid(args.specimen_file);
  if (!args.steel.empty()) s.design.steel = named_steel(args.steel).steel;
  const double accuracy = share_option("--accuracy", args.accuracy, 5e-4, 0.05, "0.05% .. 5%");
  const fs::path folder(args.folder);
  std::error_code ignored;  // the first file says it
  fs::create_directories(folder, ignored);
  std::vector<fs::path> files;
  sim::ExtrapolatedShare share;
  std::string steel;  // what of it is above its data
  std::string table = "no table: a permanent magnet makes the energy uneven in the flux";
  if (s.design.remanence != 0 && !args.tables.empty()) throw BadInput({"--out: " + table});
  if (s.design.remanence == 0) {
    sim::TableOptions t;
    t.accuracy = accuracy;
    sim::Team team(worker_count(args.threads));
    const auto choice =
        told(args.specimen_file, [&] { return obtain_field_table(folder, s.design, t, team); });
    table = fmt::format("{} ({}): {}", choice.file.string(), choice.reused ? "as stored" : "built",
                        choice.table.description);
    share = sim::extrapolated_share(choice.table);
    steel = fmt::format("  steel up to {:.3g} T; {}\n", share.largest_field,
                        extrapolated_text(choice.table, share));
    files.push_back(folder / "field-table.svg");
    const std::string title = s.name + ": " + choice.table.description;
    write_file(files.back(), table_svg(sim::TablePotential(choice.table), title));
    write_tables(args, sim::TablePotential(choice.table), s.travel(), title);
    files.insert(files.end(), args.tables.begin(), args.tables.end());
  }
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(mesh_share * accuracy);
  sim::SolenoidField field(s.design, o);
  o.sizes = o.sizes.scaled(0.5);
  sim::SolenoidField finer(s.design, o);
  double linkage_error = 0, pull_error = 0;
  const double current = args.current.value_or(0.3);
  if (!(std::fabs(current) <= 1e4))
    throw BadInput({fmt::format("--current = {}, allowed -10000 .. 10000", current)});
  Json states = Json::array();
  std::string lines;
  for (const auto& [name, gap] : {std::pair{"open", s.travel()}, {"half", s.travel() / 2}, {"closed", 0.0}}) {
    field.set_gap(gap);
    const auto p = field.at_current(current);
    const std::string title = fmt::format("{}: gap {:.2f} mm, {:.3g} A, {:.3g} Wb, pull {:.3g} N", name,
                                          gap * 1e3, current, field.flux(p), p.response.pull);
    finer.set_gap(gap);
    if (const auto f = finer.at_current(current); current != 0) {
      linkage_error = std::max(linkage_error, std::fabs(field.flux(p) / finer.flux(f) - 1));
      pull_error = std::max(pull_error, std::fabs(p.response.pull / f.response.pull - 1));
    }
    lines += "  " + title + fmt::format(", steel up to {:.3g} T\n", p.largest_field);
    states.push_back({{"gap_m", gap},
                      {"current_A", current},
                      {"psi_Wb", field.flux(p)},
                      {"pull_N", p.response.pull},
                      {"largest_field_T", p.largest_field}});
    files.push_back(folder / fmt::format("field-{}.svg", name));
    write_file(files.back(), field_svg(field, p, title));
    files.push_back(folder / fmt::format("field-{}.vtu", name));
    write_file(files.back(), to_vtu(field_grid(field.problem(), p.a)));
  }
  if (args.json) {
    Json list = Json::array();
    for (const auto& f : files) list.push_back(f.string());
    Json out{{"table", table},
             {"states", states},
             {"mesh_error_linkage", linkage_error},
             {"mesh_error_pull", pull_error},
             {"pictures", list}};
    if (!steel.empty())
      out.update(Json{{"largest_field_T", share.largest_field},
                      {"states_beyond_data", share.share},
                      {"beyond_data_from_Wb", share.from_psi}});
    fmt::print("{}\n", out.dump(2));
    return Exit::pass;
  }
  fmt::print(
      "{}\n{}{}  expected error of the mesh at these three: {:.2g} % in the linkage, {:.2g} % in the pull, "
      "by "
      "cells of half the size\n",
      table, steel, lines, linkage_error * 100, pull_error * 100);
  for (const auto& f : files) fmt::print("{}\n", f.string());
  return Exit::pass;
}

Exit describe_solenoid(const SpecimenArgs& args) {
  const auto s = read_solenoid(args.file);
  const double volts = in_range("--volts", args.volts, default_volts, 0.1, 1e4, "V");
  constexpr int places = 6;
  constexpr double accuracy = 5e-3;
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(mesh_share * accuracy);
  sim::SolenoidField field(s.design, o);
  const auto& p = s.plunger;
  const double current = volts / s.coil.resistance;
  const bool two = s.coil.hold_turns > 0;  // in series from hold_from on
  const double hold_current = two ? volts / (s.coil.resistance + s.coil.hold_resistance) : 0;
  const double hold_ratio = 1 + s.coil.hold_turns / s.design.turns;
  Json rows = Json::array();
  std::string text = fmt::format("{}: {:g} turns, {:g} ohm, {:.4g} A and {:.4g} W at {:g} V and 20 degC\n",
                                 s.name, s.design.turns, s.coil.resistance, current, volts * current, volts);
  if (two)
    text += fmt::format("hold winding from {:.2f} mm on: {:.4g} A, {:.4g} W\n", s.coil.hold_from * 1e3,
                        hold_current, volts * hold_current);
  text += fmt::format("{:>10} {:>10} {:>10} {:>12} {:>10} {:>12}\n", "travel mm", "gap mm", "current A",
                      "linkage Wb", "pull N", "to move N");
  bool moves = true;
  std::vector<double> travels;
  for (int k = 0; k < places; ++k) travels.push_back(s.travel() * k / (places - 1));
  if (two)
    travels.insert(std::upper_bound(travels.begin(), travels.end(), s.coil.hold_from), s.coil.hold_from);
  for (const double travel : travels) {
    const double gap = s.travel() - travel;
    const double load = p.return_preload + p.load + p.return_rate * travel + p.friction;
    field.set_gap(gap);
    const bool holds = two && travel >= s.coil.hold_from;
    const double flows = holds ? hold_current : current, ratio = holds ? hold_ratio : 1;
    const auto at = field.at_current(flows * ratio);
    const double linkage = field.flux(at) * ratio;
    moves = moves && at.response.pull > load;
    text += fmt::format("{:>10.3f} {:>10.3f} {:>10.4f} {:>12.5f} {:>10.3f} {:>12.3f}\n", travel * 1e3,
                        gap * 1e3, flows, linkage, at.response.pull, load);
    rows.push_back({{"travel_m", travel},
                    {"gap_m", gap},
                    {"current_A", flows},
                    {"linkage_Wb", linkage},
                    {"pull_N", at.response.pull},
                    {"load_N", load}});
  }
  text += moves ? "the pull is above spring, load and friction at all of these places\n"
                : "the pull is BELOW spring, load and friction at some of these places: it may not close\n";
  text += "no contacts, no shading ring, no closing angle: not of a solenoid\n";
  if (args.json)
    fmt::print("{}\n", Json{{"name", s.name},
                            {"current_A", current},
                            {"power_W", volts * current},
                            {"pull_above_load", moves},
                            {"places", rows}}
                           .dump(2));
  else
    fmt::print("{}", text);
  return Exit::pass;
}

}  // namespace powbench::host
