#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/cli/verbs.h"
#include "host/config/bad_input.h"
#include "host/config/specimen_file.h"
#include "host/export/field_svg.h"
#include "host/store/field_table.h"
#include "host/store/store.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;

/// "0.5%" or "0.005".
double accuracy_of(const std::string& word) {
  char* end = nullptr;
  double value = std::strtod(word.c_str(), &end);
  const std::string rest = end;
  if (rest == "%") value /= 100;
  if (end == word.c_str() || (rest != "%" && !rest.empty()) || !(value >= 5e-4 && value <= 0.05))
    throw BadInput({"--accuracy = " + word + ", allowed 0.05% .. 5%"});
  return value;
}

sim::MagnetDesign design_of(const sim::Specimen& s, const std::string& steel) {
  sim::MagnetDesign d;
  d.shape = s.shape;
  try {
    d.steel = steel.empty()
                  ? sim::Steel::power_law(s.magnet.bh_linear, s.magnet.bh_power, s.magnet.bh_exponent)
                  : sim::builtin_steel(steel);
  } catch (const std::invalid_argument& error) {
    throw BadInput({error.what()});
  }
  d.turns = s.coil.turns;
  d.residual_gap = s.magnet.residual_gap;
  return d;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw StoreError(path.string() + ": cannot be written; choose another folder with -o");
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
    const std::string title = fmt::format("{}: gap {:.2f} mm, {:.2f} Wb, {:.3g} A, pull {:.3g} N", name,
                                          gap * 1e3, psi, point.response.current, point.response.pull);
    files.push_back(folder / fmt::format("field-{}.svg", name));
    write(files.back(), field_svg(field, point, title));
  }
  return files;
}

}  // namespace

Exit show_field(const FieldArgs& args) {
  const sim::Specimen specimen =
      args.specimen_file.empty() ? sim::Specimen{} : read_specimen(args.specimen_file);
  const auto design = design_of(specimen, args.steel);
  sim::TableOptions options;
  options.accuracy = accuracy_of(args.accuracy);
  options.largest_gap = std::max(1.5 * specimen.core.travel, 0.2e-3);
  options.ring = args.ring;
  const fs::path folder(args.folder);
  sim::Team team(2);
  const auto choice = obtain_field_table(folder, design, options, team);
  const sim::TablePotential table(choice.table);
  const auto worst = [](const std::vector<double>& list) {
    return *std::max_element(list.begin(), list.end());
  };
  const double current_error = worst(choice.table.current_error), pull_error = worst(choice.table.pull_error);
  auto files = pictures(folder, design, options, specimen.core.travel);
  files.push_back(folder / "field-table.svg");
  write(files.back(), table_svg(table, specimen.name + ": " + choice.table.description));
  if (args.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto& f : files) list.push_back(f.string());
    fmt::print("{}\n", nlohmann::ordered_json{{"table", choice.file.string()},
                                              {"reused", choice.reused},
                                              {"description", choice.table.description},
                                              {"mesh_error", choice.table.mesh_error},
                                              {"worst_current_error", current_error},
                                              {"worst_pull_error", pull_error},
                                              {"least_stiffness_A_per_Wb", table.least_stiffness()},
                                              {"pictures", list}}
                           .dump(2));
    return Exit::pass;
  }
  fmt::print(
      "{} ({})\n  {}\n  expected error: mesh {:.2g} %, table {:.2g} % in the current, {:.2g} % in the pull\n",
      choice.file.string(), choice.reused ? "as stored" : "built", choice.table.description,
      choice.table.mesh_error * 100, current_error * 100, pull_error * 100);
  for (const auto& f : files) fmt::print("{}\n", f.string());
  return Exit::pass;
}

}  // namespace powbench::host
