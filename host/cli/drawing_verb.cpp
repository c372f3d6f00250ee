#include "host/cli/drawing_verb.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/counted.h"
#include "core/units.h"
#include "host/cli/percent.h"
#include "host/cli/table_files.h"
#include "host/cli/table_text.h"
#include "host/cli/threads.h"
#include "host/config/bad_input.h"
#include "host/export/field_svg.h"
#include "host/export/field_vtu.h"
#include "host/export/write_file.h"
#include "host/store/field_table.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Drawing = std::shared_ptr<const sim::DrawnMagnet>;

/// One shown state.
struct ShownState {
  std::string name;
  double gap = 0;
  sim::FieldPoint point;
  std::vector<fs::path> files;
};

/// Open, half way and closed, at half of the table's largest flux.
std::vector<ShownState> shown_states(const fs::path& folder, const Drawing& drawing, double psi) {
  sim::DrawnField field(drawing, {});
  std::vector<ShownState> out;
  for (const auto& [name, share] : {std::pair{"open", 1.0}, {"half", 0.5}, {"closed", 0.0}}) {
    ShownState s{name, share * drawing->travel, {}, {}};
    field.set_gap(s.gap);
    s.point = field.at_flux(psi, 0, {}, true);
    const auto& r = s.point.response;
    s.files.push_back(folder / fmt::format("{}-{}.svg", drawing->name, name));
    write_file(s.files.back(), field_svg(field, s.point,
                                         fmt::format("{}: gap {:.2f} mm, {:.3g} Wb, {:.3g} A, pull {:.3g} N",
                                                     name, s.gap * 1e3, psi, r.current, r.pull)));
    s.files.push_back(folder / fmt::format("{}-{}.vtu", drawing->name, name));
    write_file(s.files.back(), to_vtu(field_grid(field.problem(), s.point.a)));
    out.push_back(std::move(s));
  }
  return out;
}

constexpr int least_across_gap = 3;

}  // namespace

void refuse_drawing_options(const FieldArgs& args) {
  const auto refuse = [](bool given, const char* option, const char* why) {
    if (given) throw BadInput({fmt::format("{}: does not go with a drawing, {}", option, why)});
  };
  refuse(!args.steel.empty(), "--steel", "whose groups name their steels");
  refuse(!args.mesh_file.empty(), "--mesh", "which has a mesh");
  refuse(args.mesh_unit != "mm", "--mesh-unit", "which states its unit");
  refuse(args.symmetric, "--symmetric", "which states its symmetry");
  refuse(args.current.has_value(), "--current", "which is computed over a whole range of flux");
  refuse(args.ends, "--ends", "whose ends are drawn or are not there");
}

Exit show_drawing(const FieldArgs& args, const Drawing& drawing) {
  refuse_drawing_options(args);
  const auto& d = *drawing;
  if (args.ring && !d.has_ring()) throw BadInput({"--ring: no group of the drawing has the role ring"});
  sim::TableOptions options;
  options.accuracy = share_option("--accuracy", args.accuracy, 5e-4, 0.05, "0.05% .. 5%");
  options.largest_gap = 1.5 * d.travel;
  options.ring = args.ring;
  const fs::path folder(args.folder);
  sim::Team team(worker_count(args.threads));
  const auto [choice, table] = [&] {
    try {
      auto found = obtain_field_table(folder, drawing, options, team);
      sim::TablePotential potential(found.table);
      return std::pair{std::move(found), std::move(potential)};
    } catch (const std::invalid_argument& error) {
      throw BadInput({args.specimen_file + ": " + error.what()});
    }
  }();
  const auto& t = choice.table;
  const std::string missed = missed_accuracy(t, options.accuracy, finer_drawing, finer_drawn_table);
  const auto states = shown_states(folder, drawing, t.largest_psi() / 2);
  const fs::path picture = folder / (d.name + "-table.svg");
  write_file(picture, table_svg(table, t.description));
  write_tables(args, table, d.travel, d.name + ": " + t.description);
  const auto share = sim::extrapolated_share(t);
  const double open = d.residual_gap + 1.5 * d.travel;
  const auto angle = [&](double gap) { return sim::least_angle(d, gap) * 180 / pi; };
  if (args.json) {
    Json list = Json::array(), pictures = Json::array();
    for (const auto& s : states) {
      list.push_back({{"gap_m", s.gap},
                      {"psi_Wb", t.largest_psi() / 2},
                      {"current_A", s.point.response.current},
                      {"pull_N", s.point.response.pull},
                      {"energy_J", s.point.response.energy},
                      {"largest_field_T", s.point.largest_field}});
      for (const auto& f : s.files) pictures.push_back(f.string());
    }
    pictures.push_back(picture.string());
    Json j = table_json<Json>(choice, options.accuracy, missed);
    j.update(Json{{"largest_field_T", share.largest_field},
                  {"states_beyond_data", share.share},
                  {"air_around", sim::air_around(d)},
                  {"triangles_across_gap", sim::triangles_across_gap(d)},
                  {"states", list},
                  {"tables", args.tables},
                  {"pictures", pictures}});
    fmt::print("{}\n", j.dump(2));
    return exit_of_accuracy(missed);
  }
  fmt::print("{}", table_head(choice, missed));
  fmt::print("  steel up to {:.3g} T; {}\n", share.largest_field, extrapolated_text(t, share));
  if (const double air = sim::air_around(d); air < 0.5)
    fmt::print(
        "  little air: the outer edge is as near to iron or coil as {:.2g} of their size; below 1 it holds "
        "flux "
        "together, which no error here contains\n",
        air);
  if (const int few = sim::triangles_across_gap(d); few > 0 && few < least_across_gap)
    fmt::print("  {} across the gap; with fewer than {} the mesh can err by more than is said\n",
               counted(few, "triangle"), least_across_gap);
  fmt::print(
      "  least angle of the air that stretches: {:.2g} deg as drawn, {:.2g} closed, {:.2g} at {:.3g} mm\n",
      angle(d.drawn_gap), angle(d.residual_gap), angle(open), open * 1e3);
  for (const auto& s : states)
    fmt::print("  {:<7} gap {:>6.3f} mm, {:.4g} Wb: {:.4g} A, pull {:.4g} N, {:.3g} J\n", s.name, s.gap * 1e3,
               t.largest_psi() / 2, s.point.response.current, s.point.response.pull, s.point.response.energy);
  for (const auto& s : states)
    for (const auto& f : s.files) fmt::print("{}\n", f.string());
  fmt::print("{}\n", picture.string());
  for (const auto& f : args.tables) fmt::print("{}\n", f);
  return exit_of_accuracy(missed);
}

}  // namespace powbench::host
