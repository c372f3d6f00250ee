#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/cli/drawing_verb.h"
#include "host/cli/named_steel.h"
#include "host/cli/percent.h"
#include "host/cli/solenoid_verb.h"
#include "host/cli/table_files.h"
#include "host/cli/table_text.h"
#include "host/cli/threads.h"
#include "host/cli/verbs.h"
#include "host/config/drawing_file.h"
#include "host/config/solenoid_file.h"
#include "host/config/space_file.h"
#include "host/config/specimen_file.h"
#include "host/export/field_svg.h"
#include "host/export/field_vtu.h"
#include "host/export/write_file.h"
#include "host/import/field_mesh.h"
#include "host/run/progress.h"
#include "host/store/field_table.h"
#include "host/store/point_bytes.h"
#include "host/store/store.h"
#include "sim/models/mechanics.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;

sim::MagnetDesign design_of(const sim::Specimen& s, const std::string& steel) {
  try {
    auto design = sim::magnet_design(s);
    if (!steel.empty()) design.steel = named_steel(steel).steel;
    return design;
  } catch (const std::invalid_argument& error) {
    throw BadInput({error.what()});
  }
}

/// Open, half way, closed: at the flux that gives 1.2 T in the closed centre leg.
std::vector<fs::path> pictures(const fs::path& folder, const sim::MagnetDesign& design,
                               const sim::TableOptions& options, double travel) {
  constexpr double flux_density = 1.2;
  sim::FieldOptions field_options = sim::plan_table(design, options).field;
  sim::MagnetField field(design, field_options);
  const double psi = design.turns * design.shape.centre_width * design.shape.stack *
                     design.shape.stack_factor * flux_density;
  std::vector<fs::path> files;
  for (const auto& [name, gap] : {std::pair{"open", travel}, {"half", travel / 2}, {"closed", 0.0}}) {
    field.set_gap(gap);
    const auto point = field.at_flux(psi, 0, {}, true);
    const std::string title = fmt::format("{}: gap {:.2f} mm, {:.3g} Wb, {:.3g} A, pull {:.3g} N", name,
                                          gap * 1e3, psi, point.response.current, point.response.pull);
    files.push_back(folder / fmt::format("field-{}.svg", name));
    write_file(files.back(), field_svg(field, point, title));
    files.push_back(folder / fmt::format("field-{}.vtu", name));
    write_file(files.back(), to_vtu(field_grid(field.problem(), point.a)));
  }
  return files;
}

double metres_of(const std::string& unit) {
  for (const auto& [name, metres] : {std::pair{"mm", 1e-3}, {"m", 1.0}, {"in", 25.4e-3}})
    if (unit == name) return metres;
  throw BadInput({"--mesh-unit = " + unit + ", allowed mm, m, in"});
}

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  if (!in) throw BadInput({path + ": cannot be read"});
  return text.str();
}

/// One state on a mesh drawn elsewhere.
Exit show_mesh(const FieldArgs& args, const sim::MagnetDesign& design) {
  const double wanted = args.current.value_or(0.3);
  if (!(std::fabs(wanted) <= 1e4))
    throw BadInput({fmt::format("--current = {}, allowed -10000 .. 10000", wanted)});
  const double copies = args.symmetric ? 2 : 1;
  auto drawn = read_field_mesh(content_of(args.mesh_file), args.mesh_file,
                               {metres_of(args.mesh_unit), design.turns, copies * design.shape.stack,
                                design.steel.stacked(design.shape.stack_factor)});
  const sim::FieldProblem problem(std::move(drawn.mesh), drawn.setup);
  sim::Newton newton(problem);
  std::vector<double> a(static_cast<std::size_t>(problem.size()) + 1, 0), current;
  const auto report = newton.solve({{false, wanted, 0}}, a, current);
  double psi = 0;
  for (std::size_t k = 0; k < a.size(); ++k) psi += problem.winding(0)[k] * a[k];
  const fs::path file = fs::path(args.folder) / "field-mesh.vtu";
  std::error_code ignored;  // the first file says it
  fs::create_directories(args.folder, ignored);
  write_file(file, to_vtu(field_grid(problem, a)));
  const double energy = newton.energy(), largest = problem.largest_field(a.data());
  const double beyond = problem.share_beyond_data(a.data());
  // towards positive y
  const double force = drawn.armature.empty() ? 0 : problem.stress_force(a.data(), drawn.armature);
  if (args.json) {
    nlohmann::ordered_json out{{"unknowns", problem.size()},
                               {"converged", report.converged},
                               {"iterations", report.iterations},
                               {"current_A", wanted},
                               {"psi_Wb", psi},
                               {"energy_J", energy},
                               {"largest_field_T", largest},
                               {"steel_beyond_data", beyond}};
    if (!drawn.armature.empty()) out["force_y_N"] = force;
    out["picture"] = file.string();
    fmt::print("{}\n", out.dump(2));
  } else {
    fmt::print("{}: {} unknowns, {} iterations{}\n  {:.6g} A: {:.6g} Wb, {:.6g} J, steel up to {:.3g} T\n",
               args.mesh_file, problem.size(), report.iterations, report.converged ? "" : ", NOT CONVERGED",
               wanted, psi, energy, largest);
    fmt::print("  {:.3g} % of the steel is above its B-H data\n", beyond * 100);
    if (!drawn.armature.empty()) fmt::print("  force on the armature along y: {:.6g} N\n", force);
    fmt::print("{}\n", file.string());
  }
  return report.converged ? Exit::pass : Exit::outside_limits;
}

std::string bytes_of(const sim::TableSlice& s) {
  ByteWriter out;
  out.add(s.nodes).add(s.steel_field).add(s.air).add(s.largest_pull).add(s.stress_distance);
  for (const int n : {s.report.solutions, s.report.iterations, s.report.most_iterations, s.report.unknowns,
                      s.report.beyond_data})
    out.add(static_cast<std::int64_t>(n));
  return out.add(s.report.stress_error).bytes();
}

sim::TableSlice slice_of(const std::string& bytes) {
  ByteReader in(bytes);
  sim::TableSlice s;
  for (auto* list : {&s.nodes, &s.steel_field, &s.air}) *list = in.numbers();
  s.largest_pull = in.number();
  s.stress_distance = in.number();
  for (int* n : {&s.report.solutions, &s.report.iterations, &s.report.most_iterations, &s.report.unknowns,
                 &s.report.beyond_data})
    *n = static_cast<int>(in.integer());
  s.report.stress_error = in.number();
  return s;
}

/// Slices of the table as points: of the magnet alone (shape, steel, turns), whatever else the specimen has.
sim::SliceSource slices(Points& points, const sim::MagnetDesign& design, const sim::TableOptions& options) {
  const std::string magnet = fmt::format("{:016x}", sim::table_hash(design, options));
  return [&points, magnet](std::size_t number, const std::function<sim::TableSlice()>& solve) {
    const auto bytes =
        points.get(static_cast<std::int64_t>(number), fmt::format("{} slice {}", magnet, number),
                   [&] { return bytes_of(solve()); });
    return bytes ? std::optional(slice_of(*bytes)) : std::nullopt;
  };
}

void refuse_shards(const FieldArgs& args, bool other) {
  const ShardArgs& s = args.shards;
  if (s.database.empty() && s.shard.empty() && s.slurm == 0) return;
  if (other)
    throw BadInput(
        {args.specimen_file + ": --points-db, --shard and --slurm are for tables of a specimen's [shape]"});
  if (!args.mesh_file.empty())
    throw BadInput({"--mesh solves one state: --points-db, --shard and --slurm are for tables"});
  if (args.ends)
    throw BadInput({"--ends: --points-db, --shard and --slurm are for plane tables, allowed without --ends"});
}

/// With the ends of three dimensions; minutes with a ring, so it shows how far it is.
FieldTableChoice end_table(const fs::path& folder, const sim::MagnetDesign& design,
                           const sim::TableOptions& options, sim::Team& team) {
  std::unique_ptr<Progress> progress;
  sim::EndTableOptions ends;
  ends.progress = [&](int done, int all) {
    if (!progress) progress = std::make_unique<Progress>("three dimensions", static_cast<std::size_t>(all));
    progress->update(static_cast<std::size_t>(done));
  };
  auto choice = obtain_end_table(folder, design, options, ends, team);
  if (progress) progress->finish();
  if (!choice.reused) fmt::print(stderr, "built in {:.0f} s of CPU\n", choice.cpu_seconds);
  return choice;
}

}  // namespace

Exit show_field(const FieldArgs& args) {
  check_tables(args);
  if (names_drawing(args.specimen_file)) {
    refuse_shards(args, true);
    if (is_space_drawing(args.specimen_file))
      return show_space_drawing(args, read_space_drawing(args.specimen_file));
    return show_drawing(args, read_drawing(args.specimen_file));
  }
  if (is_solenoid_file(args.specimen_file)) {
    refuse_shards(args, true);
    return show_solenoid_field(args);
  }
  const sim::Specimen specimen =
      args.specimen_file.empty() ? sim::Specimen{} : read_specimen(args.specimen_file);
  refuse_shards(args, specimen.drawn || specimen.in_space);
  if (specimen.in_space) return show_space_drawing(args, specimen.in_space);
  if (specimen.drawn) return show_drawing(args, specimen.drawn);
  const auto design = design_of(specimen, args.steel);
  if (!args.mesh_file.empty()) return show_mesh(args, design);
  if (!specimen.shaped)
    throw BadInput({args.specimen_file +
                    ": [shape]: none of its keys is set; the field is that of a drawn core, " +
                    "`powbench plan template specimen` shows its keys: take the # off those that are known"});
  sim::TableOptions options;
  options.accuracy = share_option("--accuracy", args.accuracy, 5e-4, 0.05, "0.05% .. 5%");
  options.largest_gap = std::max(1.5 * specimen.core.travel, 0.2e-3);
  options.ring = args.ring;
  const fs::path folder(args.folder);
  if (args.shards.slurm > 0) {
    fmt::print("{}", slurm_script(args.shards, args.shards.database));
    return Exit::pass;
  }
  sim::Team team(worker_count(args.threads));
  Points points = open_points(args.shards);
  if (points.part()) {
    sim::build_table(design, options, team, nullptr, slices(points, design, options));
    say_points(points, args.shards);
    return Exit::pass;
  }
  const auto choice =
      args.ends ? end_table(folder, design, options, team)
                : obtain_field_table(folder, design, options, team, slices(points, design, options));
  say_points(points, args.shards);
  const sim::TablePotential table(choice.table);
  const std::string missed =
      missed_accuracy(choice.table, options.accuracy, "the sizes of its elements are at their smallest",
                      "its cells are at their smallest");
  const auto beyond = sim::extrapolated_share(choice.table);
  auto files = pictures(folder, design, options, specimen.core.travel);
  files.push_back(folder / "field-table.svg");
  write_file(files.back(), table_svg(table, specimen.name + ": " + choice.table.description));
  write_tables(args, table, specimen.core.travel, specimen.name + ": " + choice.table.description);
  if (args.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto& f : files) list.push_back(f.string());
    nlohmann::ordered_json j = table_json<nlohmann::ordered_json>(choice, options.accuracy, missed);
    j.update(nlohmann::ordered_json{{"largest_field_T", beyond.largest_field},
                                    {"data_end_T", choice.table.data_end},
                                    {"states_beyond_data", beyond.share},
                                    {"beyond_data_from_Wb", beyond.from_psi},
                                    {"least_stiffness_A_per_Wb", table.least_stiffness()},
                                    {"pictures", list},
                                    {"tables", args.tables}});
    fmt::print("{}\n", j.dump(2));
    return exit_of_accuracy(missed);
  }
  fmt::print("{}", table_head(choice, missed));
  fmt::print("  steel up to {:.3g} T; {}\n", beyond.largest_field, extrapolated_text(choice.table, beyond));
  for (const auto& f : files) fmt::print("{}\n", f.string());
  for (const auto& f : args.tables) fmt::print("{}\n", f);
  return exit_of_accuracy(missed);
}

}  // namespace powbench::host
