#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/cli/drawing_verb.h"
#include "host/cli/percent.h"
#include "host/cli/table_files.h"
#include "host/cli/table_text.h"
#include "host/config/bad_input.h"
#include "host/export/field_svg.h"
#include "host/export/space_svg.h"
#include "host/export/space_vtu.h"
#include "host/export/write_file.h"
#include "host/run/progress.h"
#include "host/store/field_table.h"

namespace powbench::host {
namespace {

using SpaceJson = nlohmann::ordered_json;

/// One shown state.
struct SpaceState {
  std::string name;
  double gap = 0, largest_field = 0;
  sim::MagneticResponse response;
  std::vector<std::filesystem::path> files;
};

/// Open, half way and closed, at half of the table's largest flux.
std::vector<SpaceState> space_states(const std::filesystem::path& folder, const sim::SpaceMagnet& d,
                                     double psi) {
  auto field = sim::space_field(d, false);
  std::vector<SpaceState> out;
  for (const auto& [name, share] : {std::pair{"open", 1.0}, {"half", 0.5}, {"closed", 0.0}}) {
    SpaceState s{name, share * d.travel, 0, {}, {}};
    field.set_gap(s.gap);
    const auto p = field.at_flux(psi, 0, {}, true);
    s.response = p.response;
    const VtuGrid grid = space_grid(field.function(), p.solution.state);
    s.largest_field = field.function().largest_steel_field(p.solution.state);
    s.files.push_back(folder / fmt::format("{}-{}.svg", d.name, name));
    write_file(s.files.back(),
               space_svg(d, field.function().problem().mesh, grid.cell_fields[1].values,
                         fmt::format("{}: gap {:.2f} mm, {:.3g} Wb, {:.3g} A, pull {:.3g} N", name,
                                     s.gap * 1e3, psi, s.response.current, s.response.pull)));
    s.files.push_back(folder / fmt::format("{}-{}.vtu", d.name, name));
    write_file(s.files.back(), to_vtu(grid));
    out.push_back(std::move(s));
  }
  return out;
}

FieldTableChoice space_table(const FieldArgs& args, const sim::SpaceMagnet& d,
                             const sim::TableOptions& options) {
  std::unique_ptr<Progress> progress;
  const auto tell = [&](int done, int all) {
    if (!progress) progress = std::make_unique<Progress>("states in space", static_cast<std::size_t>(all));
    progress->update(static_cast<std::size_t>(done));
  };
  try {
    auto choice = obtain_field_table(args.folder, d, options, tell);
    if (progress) progress->finish();
    if (!choice.reused) fmt::print(stderr, "built in {:.0f} s of CPU\n", choice.cpu_seconds);
    return choice;
  } catch (const std::invalid_argument& error) {
    throw BadInput({args.specimen_file + ": " + error.what()});
  }
}

}  // namespace

Exit show_space_drawing(const FieldArgs& args, const std::shared_ptr<const sim::SpaceMagnet>& drawing) {
  refuse_drawing_options(args);
  const auto& d = *drawing;
  if (args.ring && !d.has_ring()) throw BadInput({"--ring: no group of the drawing has the role ring"});
  sim::TableOptions options;
  options.accuracy = share_option("--accuracy", args.accuracy, 5e-4, 0.05, "0.05% .. 5%");
  options.largest_gap = 1.5 * d.travel;
  options.ring = args.ring;
  const auto choice = space_table(args, d, options);
  const auto& t = choice.table;
  const sim::TablePotential table(t);
  const std::string missed = missed_accuracy(t, options.accuracy, finer_drawing, finer_drawn_table);
  const auto share = sim::extrapolated_share(t);
  const std::filesystem::path folder(args.folder);
  const auto states = space_states(folder, d, t.psi.back() / 2);
  const auto picture = folder / (d.name + "-table.svg");
  write_file(picture, table_svg(table, t.description));
  write_tables(args, table, d.travel, d.name + ": " + t.description);
  if (args.json) {
    SpaceJson list = SpaceJson::array(), pictures = SpaceJson::array();
    for (const auto& s : states) {
      list.push_back({{"gap_m", s.gap},
                      {"psi_Wb", t.psi.back() / 2},
                      {"current_A", s.response.current},
                      {"pull_N", s.response.pull},
                      {"energy_J", s.response.energy},
                      {"largest_field_T", s.largest_field}});
      for (const auto& f : s.files) pictures.push_back(f.string());
    }
    pictures.push_back(picture.string());
    SpaceJson j = table_json<SpaceJson>(choice, options.accuracy, missed);
    j.update(
        SpaceJson{{"states_beyond_data", t.steel_field.empty() ? SpaceJson(nullptr) : SpaceJson(share.share)},
                  {"states", list},
                  {"tables", args.tables},
                  {"pictures", pictures}});
    fmt::print("{}\n", j.dump(2));
    return exit_of_accuracy(missed);
  }
  fmt::print("{}  {}\n", table_head(choice, missed), extrapolated_text(t, share));
  for (const auto& s : states)
    fmt::print(
        "  {:<7} gap {:>6.3f} mm, {:.4g} Wb: {:.4g} A, pull {:.4g} N, {:.3g} J, steel up to {:.3g} T\n",
        s.name, s.gap * 1e3, t.psi.back() / 2, s.response.current, s.response.pull, s.response.energy,
        s.largest_field);
  for (const auto& s : states)
    for (const auto& f : s.files) fmt::print("{}\n", f.string());
  fmt::print("{}\n", picture.string());
  for (const auto& f : args.tables) fmt::print("{}\n", f);
  return exit_of_accuracy(missed);
}

}  // namespace powbench::host
