#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "host/cli/percent.h"
#include "host/cli/solenoid_verb.h"
#include "host/cli/specimen_verb.h"
#include "host/config/bad_input.h"
#include "host/config/solenoid_file.h"
#include "host/config/specimen_file.h"
#include "host/study/scene_fields.h"
#include "host/study/specimen_facts.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/specimen/specimen_fields.h"
#include "sim/study/circuit_of_field.h"

namespace powbench::host {
namespace {

/// The table of the specimen's field, without what the ends of a shape add.
std::shared_ptr<const sim::TablePotential> field_of(const sim::Specimen& s, const CircuitArgs& args) {
  FieldCache cache;
  cache.folder = args.cache;
  cache.accuracy = share_option("--accuracy", args.accuracy, 5e-4, 0.05, "0.05% .. 5%");
  cache.say = [](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  const auto rung = obtain_field("table", s, cache);
  return std::dynamic_pointer_cast<const sim::TablePotential>(rung.potential({s, {}, {}}));
}

/// The keys of the circuit as lines of a specimen file.
std::string circuit_lines(const sim::Specimen& s, bool ring) {
  std::string coil, magnet;
  for (const auto& f : sim::specimen_fields()) {
    const bool law = f.key.starts_with("bh_");
    const bool wanted = f.key == "leakage_H" || f.key == "pole_area_mm2" || f.key == "iron_length_mm" ||
                        f.key == "fringing" || (f.key == "shaded_share" && f.section == "magnet") ||
                        (law && s.magnet.steel.empty());
    if (!wanted) continue;
    (f.section == "coil" ? coil : magnet) += fmt::format("{} = {:.6g}\n", f.key, f.get(s) / f.si_per_unit);
  }
  return "[coil]\n" + coil + "\n[magnet]\n" + magnet + (ring ? "" : "# no shading ring\n");
}

}  // namespace

Exit identify_specimen_circuit(const CircuitArgs& args) {
  if (is_solenoid_file(args.file)) throw BadInput({args.file + ": a solenoid has no lumped circuit"});
  const sim::Specimen s = args.file.empty() ? sim::Specimen{} : read_specimen(args.file);
  const auto table = field_of(s, args);
  const double rated = 1.3 * std::sqrt(2.0) * args.volts / (2 * pi * args.hertz);
  const double largest = std::min(rated, table->table().largest_psi());
  sim::Team team(2);
  const auto fit = [&] {
    try {
      return sim::identify_circuit(s, *table, largest, team);
    } catch (const std::invalid_argument& error) {
      throw BadInput({args.file + ": " + error.what()});
    }
  }();
  if (args.json) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const auto& d : fit.by_gap)
      rows.push_back({{"gap_m", d.gap},
                      {"current_rms", d.current_rms},
                      {"current_worst", d.current_worst},
                      {"pull_rms", d.pull_rms},
                      {"pull_worst", d.pull_worst}});
    fmt::print("{}\n", nlohmann::ordered_json{{"specimen", resolved_text(fit.specimen)},
                                              {"largest_flux_linkage_Wb", largest},
                                              {"current_rms", fit.all.current_rms},
                                              {"pull_rms", fit.all.pull_rms},
                                              {"at_end_of_range", fit.at_end},
                                              {"by_gap", rows}}
                           .dump(2));
    return Exit::pass;
  }
  fmt::print(
      "# The lumped circuit nearest to the field of '{}', without current in the ring, at flux\n"
      "# linkages up to {:.4g} Wb ({}).\n"
      "# Deviation of the circuit, per cent of the value or of 2 % of the largest:\n"
      "#  gap mm   current rms    worst   pull rms    worst\n",
      s.name, largest,
      largest < rated ? "the end of the table"
                      : fmt::format("1.3 times that of {:g} V at {:g} Hz", args.volts, args.hertz));
  for (const auto& d : fit.by_gap)
    fmt::print("#  {:6.3f}   {:11.1f}  {:7.1f}   {:8.1f}  {:7.1f}\n", d.gap * 1e3, 100 * d.current_rms,
               100 * d.current_worst, 100 * d.pull_rms, 100 * d.pull_worst);
  fmt::print("#     all   {:11.1f}  {:7.1f}   {:8.1f}  {:7.1f}\n", 100 * fit.all.current_rms,
             100 * fit.all.current_worst, 100 * fit.all.pull_rms, 100 * fit.all.pull_worst);
  if (!fit.at_end.empty())
    fmt::print("# At the end of its range: {}. The circuit has no law for what the field does there.\n",
               fmt::join(fit.at_end, ", "));
  if (table->has_ring())
    fmt::print(
        "# With current in the shading ring the deviation is larger and not known; that current decides how "
        "the\n"
        "# closed core holds. `powbench sim --fields auto` compares the closings.\n");
  fmt::print("{}", circuit_lines(fit.specimen, table->has_ring()));
  return Exit::pass;
}

Exit describe_specimen(const SpecimenArgs& args) {
  if (is_solenoid_file(args.file)) return describe_solenoid(args);
  const sim::Specimen s = args.file.empty() ? sim::Specimen{} : read_specimen(args.file);
  Conditions rated;
  rated.supply_volts = args.volts.value_or(230);
  rated.mains_hertz = args.hertz.value_or(50);
  const auto facts = specimen_facts(s, rated);
  fmt::print("{}", args.json ? facts_json(s, facts) : facts_text(s, rated, facts));
  return Exit::pass;
}

Exit convert_specimen(const SpecimenArgs& args) {
  constexpr std::string_view mark = "# converted: a restitution is the rebound of a drop test";
  const sim::Specimen former = read_specimen(args.file);
  std::string first;
  std::getline(std::ifstream(args.file), first);
  if (first == mark) throw BadInput({args.file + ":1: is converted already; a second time would change it"});
  fmt::print("{}\n{}", mark, resolved_text(sim::with_rebounds(former)));
  fmt::print(stderr,
             "{}: stop_restitution, contact_restitution and seat_damping converted; the closings stay as "
             "they were, if the file is of the former definition. One that is new already, such as a "
             "template, would be changed: nothing in it tells\n",
             args.file);
  return Exit::pass;
}

}  // namespace powbench::host
