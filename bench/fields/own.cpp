// Own drawings: three magnets from the outlines of docs/examples/own-magnet with other lengths, each drawn once and
// moved by its air, beside FreeFem++ and GetDP on meshes of gmsh made anew at every gap. And how long a mesh takes to
// its table of 24 x 24, of these and two more.
//   fields_own [--tables] [--json PATH]     --tables: without the comparison

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "bench/fields/json_out.h"
#include "bench/fields/own_peer.h"
#include "bench/fields/peer_run.h"
#include "core/cpu_time.h"

using namespace powbench;

namespace {

const std::string outlines = std::string(POWBENCH_SOURCE_DIR) + "/docs/examples/own-magnet";

struct Own {
  const char* name;
  const char* outline;
  const char* lengths;  ///< for gmsh
  double residual_gap, travel;
};

constexpr Own magnets[] = {
    {"E-core, wide legs", "e-core",
     "-setnumber centre 10 -setnumber outer 11 -setnumber window 14 -setnumber armature 12", 50e-6, 5e-3},
    {"U-core, long legs", "u-core",
     "-setnumber leg 16 -setnumber window 22 -setnumber depth 38 -setnumber shaded 9 -setnumber yoke 15",
     60e-6, 4e-3},
    {"pot, thin disc", "pot",
     "-setnumber core 9 -setnumber inner_radius 22 -setnumber radius 26 -setnumber disc 7 -setnumber depth "
     "26",
     80e-6, 3e-3},
};

double wall() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The comparison, state by state; false: there is no gmsh.
bool compare(bench::OwnPeer& peer, nlohmann::ordered_json& out) {
  std::printf(
      "own drawings moved by their air, beside peers on meshes made at each gap; psi and F at given "
      "current\n");
  std::printf("%-18s %7s %7s | %10s %9s | %8s %8s | %8s\n", "", "gap mm", "A", "own Wb", "own N", "psi %",
              "F %", "psi %");
  std::printf("%-18s %7s %7s | %10s %9s | %17s | %8s\n", "", "", "", "", "", "FreeFem++", "GetDP");
  double worst_flux = 0, worst_pull = 0, worst_getdp = 0;
  for (const auto& own : magnets) {
    const auto drawing = peer.drawing(own.outline, own.lengths, 1.5e-3, 1, own.residual_gap, own.travel);
    if (!drawing) {
      std::printf("gmsh is not here: no comparison\n");
      return false;
    }
    sim::DrawnField field(drawing, {});
    for (const double gap : {0.0, 0.5e-3, own.travel})
      for (const double current : {0.15, 0.6}) {
        field.set_gap(gap);
        const auto p = field.at_current(current, 0);
        const double psi = field.fluxes(p).first;
        const auto other = peer.solve(own.outline, own.lengths, gap + own.residual_gap, 0.7, current);
        std::printf("%-18s %7.3f %7.2f | %10.6f %9.4g |", own.name, gap * 1e3, current, psi, p.response.pull);
        if (!other) {
          std::printf(" no FreeFem++\n");
          continue;
        }
        const double flux = 100 * (psi / other->flux - 1), pull = 100 * (p.response.pull / other->pull - 1);
        worst_flux = std::max(worst_flux, std::fabs(flux));
        worst_pull = std::max(worst_pull, std::fabs(pull));
        std::printf(" %8.3f %8.3f |", flux, pull);
        nlohmann::ordered_json row{{"magnet", own.name},          {"gap_m", gap},
                                   {"current_A", current},        {"psi_Wb", psi},
                                   {"pull_N", p.response.pull},   {"freefem_psi_percent", flux},
                                   {"freefem_pull_percent", pull}};
        if (other->getdp_flux > 0) {
          const double apart = 100 * (psi / other->getdp_flux - 1);
          worst_getdp = std::max(worst_getdp, std::fabs(apart));
          std::printf(" %8.3f", apart);
          row["getdp_psi_percent"] = apart;
        }
        std::printf("\n");
        out.push_back(row);
      }
  }
  std::printf("worst: FreeFem++ psi %.3f %%, F %.3f %%; GetDP psi %.3f %%\n", worst_flux, worst_pull,
              worst_getdp);
  return true;
}

/// One row: from the mesh file to the table. Errors are the table's own: of the mesh, and the largest of a cell.
nlohmann::ordered_json table_row(const bench::OwnPeer& peer, const Own& own) {
  const double started = wall(), cpu = process_cpu_seconds();
  const auto drawing = peer.read(own.outline, own.residual_gap, own.travel);
  sim::TableOptions o;
  o.psi_nodes = o.gap_nodes = 24;
  o.ring = false;
  o.largest_gap = 1.5 * own.travel;
  sim::Team team(2);
  sim::TableReport report;
  const auto table = sim::build_table(drawing, o, team, &report);
  const double took = wall() - started, spent = process_cpu_seconds() - cpu;
  const double current = table.worst_current_error(), pull = table.worst_pull_error();
  std::printf("%-18s %8d %8.2f %8.2f %10d %8.2f %8.3f %8.3f\n", own.name, report.unknowns, spent, took,
              report.iterations, table.mesh_error * 100, current * 100, pull * 100);
  return {{"magnet", own.name},
          {"unknowns", report.unknowns},
          {"cpu_s", spent},
          {"wall_s", took},
          {"iterations", report.iterations},
          {"mesh_error", table.mesh_error},
          {"current_error", current},
          {"pull_error", pull}};
}

nlohmann::ordered_json tables(bench::OwnPeer& peer, const std::string& folder) {
  std::printf(
      "\nfrom the mesh file to a table of 24 x 24, two threads; largest errors by its own estimate\n");
  std::printf("%-18s %8s %8s %8s %10s %8s %8s %8s\n", "", "unknowns", "CPU s", "wall s", "iterations",
              "mesh %", "i %", "F %");
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& own : magnets)
    if (peer.drawing(own.outline, own.lengths, 1.5e-3, 1, own.residual_gap, own.travel))
      rows.push_back(table_row(peer, own));
  const bench::OwnPeer examples(outlines, outlines);
  rows.push_back(table_row(examples, {"u-core.msh", "u-core", "", 40e-6, 4e-3}));
  const Own fine{"E-core, finer", "e-core", "-setnumber centre 12 -setnumber window 10", 40e-6, 4e-3};
  bench::OwnPeer other(folder + "-fine", outlines);
  if (other.drawing(fine.outline, fine.lengths, 1.5e-3, 0.7, fine.residual_gap, fine.travel))
    rows.push_back(table_row(other, fine));
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = (std::filesystem::temp_directory_path() / "powbench-own").string();
  bench::OwnPeer peer(folder, outlines);
  nlohmann::ordered_json states = nlohmann::ordered_json::array();
  const bool only_tables = bench::flag(argc, argv, "--tables");
  if (!only_tables && !compare(peer, states)) return 0;
  const auto rows = tables(peer, folder);
  return bench::write_json(argc, argv, {{"states", states}, {"tables", rows}});
}
