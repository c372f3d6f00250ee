// TEAM 13, an E-core with currents in coil and shading ring, a C-core and a drawn relay, by GetDP on meshes of gmsh:
// vector potential on edges of order 2, from below; one row a mesh.
//   space_peer [--case team13 | ring | closed_leg | relay] [--json PATH]      without --case: all of them

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/fields/json_out.h"
#include "bench/fields/peer_run.h"
#include "bench/space/team13.h"
#include "core/cpu_time.h"
#include "sim/magnetics/plane/core_outline.h"
#include "sim/magnetics/space/import.h"
#include "sim/magnetics/space/magnet_field.h"
#include "sim/magnetics/space/space_magnet.h"
#include "sim/magnetics/steel.h"

namespace {

namespace bench = powbench::bench;
namespace sim = powbench::sim;

/// The curve as lists of GetDP, dense enough for linear interpolation.
std::string steel_lists(const powbench::sim::Steel& steel) {
  std::ostringstream b, h;
  b.precision(9);
  h.precision(9);
  const auto add = [&](double value) {
    b << (value > 0 ? ", " : "") << value;
    h << (value > 0 ? ", " : "") << steel.h(value);
  };
  for (int k = 0; k < 20; ++k) add(0.005 * k);
  for (int k = 5; k < 115; ++k) add(0.02 * k);
  for (const double value : {2.5, 3.0, 4.0, 10.0}) add(value);
  return "bs() = {" + b.str() + "};\nhs() = {" + h.str() + "};\n";
}

/// The last number of each line, |mean| of them.
double mean_of_last(const std::string& path) {
  std::ifstream in(path);
  double sum = 0, value = 0;
  int count = 0;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    bool any = false;
    while (words >> value) any = true;
    if (!any) continue;
    sum += value;
    ++count;
  }
  return count ? std::fabs(sum / count) : std::numeric_limits<double>::quiet_NaN();
}

/// From GetDP's log: "System 1/1: 282153 Dofs".
int unknowns_of(const std::string& path) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);)
    if (const auto at = line.find("System 1/1: "); at != std::string::npos)
      return std::stoi(line.substr(at + 12));
  return 0;
}

/// gmsh on NAME.geo and GetDP on PROBLEM.pro in a folder: CPU seconds of the solution, nothing where one fails.
std::optional<double> solve(const std::string& folder, const std::string& name, const std::string& problem,
                            double size) {
  const std::string in = "cd '" + folder + "' && ";
  const auto mesh =
      bench::cpu_of(in + "gmsh -v 0 -nt 1 -3 -format msh22 -setnumber size " + std::to_string(size) + " " +
                    name + ".geo -o " + name + ".msh > gmsh.log 2>&1");
  if (!mesh) return std::nullopt;
  return bench::cpu_of(in + "getdp " + problem + ".pro -msh " + name +
                       ".msh -solve Run -pos Out -v 4 > getdp.log 2>&1");
}

/// A folder with the input of a case.
std::string prepared(const std::string& name, const std::string& problem) {
  const std::string folder = (std::filesystem::temp_directory_path() / ("powbench-" + name)).string();
  std::filesystem::create_directories(folder);
  for (const std::string& file : {name + ".geo", problem + ".pro", std::string("vector_potential.pro")})
    std::filesystem::copy_file(std::string(POWBENCH_SOURCE_DIR) + "/bench/space/peers/" + file,
                               folder + "/" + file, std::filesystem::copy_options::overwrite_existing);
  return folder;
}

nlohmann::ordered_json team13_rows(bool installed) {
  auto list = nlohmann::ordered_json::array();
  std::printf(
      "TEAM 13, 1000 A, by GetDP: edges of order 2 on tetrahedra, flux linkage from below; plate averages, "
      "per "
      "cent off the measured ones\n%9s %8s %10s",
      "unknowns", "CPU s", "psi mWb");
  for (const auto& row : bench::team13_plate) std::printf(" %4.0f mm", row.z_mm);
  std::printf("\n");
  if (!installed) return list;
  const std::string folder = prepared("team13", "team13");
  bench::write_file(folder + "/steel.pro", steel_lists(sim::builtin_steel("team13")));
  for (const double size : {4.0, 3.0, 2.0}) {
    std::filesystem::remove(folder + "/psi.txt");
    const auto cpu = solve(folder, "team13", "team13", size);
    const double psi = mean_of_last(folder + "/psi.txt");
    if (!cpu || !std::isfinite(psi)) {
      std::printf("size %.1f: no result, see %s/getdp.log\n", size, folder.c_str());
      continue;
    }
    const int unknowns = unknowns_of(folder + "/getdp.log");
    std::printf("%9d %8.1f %10.6f", unknowns, *cpu, psi * 1e3);
    auto errors = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < std::size(bench::team13_plate); ++k) {
      const double b = mean_of_last(folder + "/plate" + std::to_string(k) + ".txt");
      errors.push_back(100 * (b / bench::team13_plate[k].b - 1));
      std::printf(" %+7.2f", errors.back().get<double>());
    }
    std::printf("\n");
    std::fflush(stdout);
    list.push_back({{"unknowns", unknowns}, {"cpu_s", *cpu}, {"psi", psi}, {"plate_error_percent", errors}});
  }
  return list;
}

/// The edges of the core in mm, as gmsh and GetDP read them, and its currents.
std::string outline(const sim::MagnetDesign& d, double gap, double current, double ring_current) {
  const auto& s = d.shape;
  const sim::CoreOutline o(s, gap + d.residual_gap);
  const double y1 = s.stack / 2, coil_y1 = y1 + o.coil_left - o.x1;
  std::ostringstream out;
  out.precision(12);
  const std::pair<const char*, double> edges[] = {{"x1", o.x1},
                                                  {"x2", o.x2},
                                                  {"x3", o.x3},
                                                  {"yoke_bottom", o.yoke_bottom},
                                                  {"window_bottom", o.window_bottom},
                                                  {"face", o.face},
                                                  {"window_top", o.window_top},
                                                  {"yoke_top", o.yoke_top},
                                                  {"coil_left", o.coil_left},
                                                  {"coil_right", o.coil_right},
                                                  {"coil_bottom", o.coil_bottom},
                                                  {"coil_top", o.coil_top},
                                                  {"ring_left", o.ring_left},
                                                  {"slot_left", o.slot_left},
                                                  {"slot_right", o.slot_right},
                                                  {"ring_bottom", o.ring_bottom},
                                                  {"y1", y1},
                                                  {"coil_y1", coil_y1},
                                                  {"coil_y2", coil_y1 + s.coil_width},
                                                  {"ring_y2", y1 + s.ring_slot}};
  for (const auto& [name, at] : edges) out << name << " = " << at * 1e3 << ";\n";
  out << "copies = " << (o.half ? 4 : 2) << ";\n";
  out << "turns = " << d.turns << ";\ncurrent = " << current << ";\nring_current = " << ring_current << ";\n";
  return out.str();
}

/// A core, its iron without insulation, at 1 mm: a coil current and, if it has rings, a current against it. The scalar
/// potential bounds the co-energy from above, the vector potential from below, both in the same box.
struct CoreCase {
  const char* name;
  const char* geometry;
  sim::MagnetDesign design;
  double current, ring_current;
  std::vector<double> scales, sizes;  ///< of the meshes, own and of gmsh
};

nlohmann::ordered_json core_rows(const CoreCase& c, bool installed) {
  constexpr double gap = 1e-3;
  const sim::MagnetDesign& d = c.design;
  const bool rings = d.shape.ring_share > 0;
  auto list = nlohmann::ordered_json::array();
  std::printf("\n%s at a gap of %g mm, %g A in the coil", c.name, gap * 1e3, c.current);
  if (rings) std::printf(", %g A in the rings", c.ring_current);
  std::printf(": flux linkages\n%-22s %9s %8s %10s%s\n", "", "unknowns", "CPU s", "coil Wb",
              rings ? "   ring mWb" : "");
  const auto add = [&](const char* code, int unknowns, double cpu, double psi, double ring) {
    std::printf("%-22s %9d %8.1f %10.6f", code, unknowns, cpu, psi);
    if (rings) std::printf(" %10.6f", ring * 1e3);
    std::printf("\n");
    std::fflush(stdout);
    list.push_back({{"code", code}, {"unknowns", unknowns}, {"cpu_s", cpu}, {"psi", psi}});
    if (rings) list.back()["ring"] = ring;
  };
  for (const double scale : c.scales) {
    const double start = powbench::process_cpu_seconds();
    sim::space::MagnetField field(d, sim::space::CoreMeshSizes{}.scaled(scale));
    field.set_gap(gap);
    const auto p = field.at_current(c.current, c.ring_current);
    add("powbench, from above", field.unknowns(), powbench::process_cpu_seconds() - start, p.psi, p.ring);
  }
  if (!installed) return list;
  const std::string folder = prepared(c.geometry, "core");
  bench::write_file(folder + "/groups.pro", "Group { Iron = Region[1]; Air = Region[2]; }\n");
  bench::write_file(folder + "/outline.pro", outline(d, gap, c.current, c.ring_current));
  bench::write_file(folder + "/steel.pro", steel_lists(d.steel));
  for (const double size : c.sizes) {
    for (const char* name : {"/psi.txt", "/ring.txt"}) std::filesystem::remove(folder + name);
    const auto cpu = solve(folder, c.geometry, "core", size);
    const double psi = mean_of_last(folder + "/psi.txt"), ring = mean_of_last(folder + "/ring.txt");
    if (cpu && std::isfinite(psi) && std::isfinite(ring))
      add("GetDP, from below", unknowns_of(folder + "/getdp.log"), *cpu, psi, ring);
    else
      std::printf("size %.1f: no result, see %s/getdp.log\n", size, folder.c_str());
  }
  return list;
}

nlohmann::ordered_json ring_rows(bool installed) {
  sim::MagnetDesign d;
  d.shape.stack_factor = 1;
  return core_rows({"The reference core", "ring", d, 0.6, -300, {2.8, 1.4, 1.0}, {3.0, 2.0, 1.5}}, installed);
}

/// The closed leg saturates: it has half of the width of the coil's.
nlohmann::ordered_json closed_leg_rows(bool installed) {
  sim::MagnetDesign d;
  d.shape.stack_factor = 1;
  d.shape.legs = 2;
  d.shape.closed_leg = 1;
  d.shape.ring_share = 0;
  return core_rows({"A C-core", "c_core", d, 1, 0, {2.8, 1.4, 1.0}, {3.0, 2.0, 1.5}}, installed);
}

/// The relay of docs/examples/own-magnet, as drawn: its shape is that of a C-core without a window above the gap.
sim::MagnetDesign relay_design() {
  sim::MagnetDesign d;
  auto& s = d.shape;
  s.legs = 2;
  s.closed_leg = 1;
  s.ring_share = 0;
  s.centre_width = s.coil_width = 10e-3;
  s.outer_width = 8e-3;
  s.window_width = 14e-3;
  s.fixed_window = 30e-3;
  s.moving_window = 0;
  s.yoke = 6e-3;
  s.stack = 12e-3;
  s.stack_factor = 1;
  s.coil_height = 26e-3;
  s.coil_offset = 2e-3;
  d.turns = 3000;
  d.residual_gap = 60e-6;
  d.steel = sim::builtin_steel("m530-50a");
  return d;
}

/// The drawing on a mesh of gmsh in m.
sim::SpaceMagnet relay_drawing(const sim::MagnetDesign& d, const std::string& mesh) {
  using sim::DrawnRole;
  sim::SpaceMagnet m;
  m.parts = {{"core", DrawnRole::fixed, 0},    {"armature", DrawnRole::armature, 0},
             {"hinge", DrawnRole::stretch, 0}, {"coil", DrawnRole::coil, -1},
             {"bobbin", DrawnRole::air, -1},   {"air", DrawnRole::stretch, -1}};
  const sim::CoreOutline o(d.shape, 1e-3);
  m.parts[3].coil = {0,
                     0,
                     o.coil_left,
                     d.shape.stack / 2 + o.coil_left - o.x1,
                     0,
                     d.shape.coil_width,
                     o.coil_bottom,
                     o.coil_top,
                     d.turns};
  m.steels = {d.steel};
  m.copies = 2;
  m.residual_gap = d.residual_gap;
  std::ifstream in(mesh, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  m.mesh = sim::space::straight_tetrahedra(sim::space::import_mesh(
      sim::read_msh(bytes.str()), 1, {{1, 0}, {2, 1}, {3, 2}, {4, 3}, {5, 4}, {6, 5}}));
  m.motion = sim::space_motion(m);
  return m;
}

nlohmann::ordered_json relay_rows(bool installed) {
  const auto d = relay_design();
  auto list = nlohmann::ordered_json::array();
  std::printf(
      "\nThe relay of docs/examples/own-magnet as drawn, at a gap of 1 mm: flux linkage of the coil on the "
      "same "
      "tetrahedra\n%8s %9s %8s %10s %9s %8s %10s\n%8s %30s %30s\n",
      "A", "unknowns", "CPU s", "Wb", "unknowns", "CPU s", "Wb", "", "drawing, from above",
      "GetDP, from below");
  if (!installed) return list;
  const std::string folder = prepared("relay", "core");
  bench::write_file(folder + "/groups.pro", "Group { Iron = Region[{1, 2, 3}]; Air = Region[{4, 5, 6}]; }\n");
  std::filesystem::copy_file(std::string(POWBENCH_SOURCE_DIR) + "/docs/examples/own-magnet/relay.geo",
                             folder + "/drawing.geo", std::filesystem::copy_options::overwrite_existing);
  bench::write_file(folder + "/steel.pro", steel_lists(d.steel));
  for (const double size : {1.25, 0.9})
    for (const double current : {0.05, 0.3}) {
      bench::write_file(folder + "/outline.pro", outline(d, 1e-3 - d.residual_gap, current, 0));
      std::filesystem::remove(folder + "/psi.txt");
      const auto cpu = solve(folder, "relay", "core", size);
      const double psi = mean_of_last(folder + "/psi.txt");
      if (!cpu || !std::isfinite(psi)) {
        std::printf("size %.2f: no result, see %s/getdp.log\n", size, folder.c_str());
        continue;
      }
      const double start = powbench::process_cpu_seconds();
      auto field = sim::space_field(relay_drawing(d, folder + "/relay.msh"), false);
      const auto p = field.at_current(current);
      const double own = powbench::process_cpu_seconds() - start;
      const int unknowns = unknowns_of(folder + "/getdp.log");
      std::printf("%8.2f %9d %8.1f %10.6f %9d %8.1f %10.6f\n", current, field.unknowns(), own, p.psi,
                  unknowns, *cpu, psi);
      std::fflush(stdout);
      list.push_back({{"current_a", current},
                      {"unknowns", field.unknowns()},
                      {"cpu_s", own},
                      {"psi", p.psi},
                      {"peer_unknowns", unknowns},
                      {"peer_cpu_s", *cpu},
                      {"peer_psi", psi}});
    }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  const bool installed = bench::have_program("gmsh") && bench::have_program("getdp");
  if (!installed) std::printf("gmsh or getdp is not installed\n");
  const std::string only = bench::option(argc, argv, "--case");
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  if (only.empty() || only == "team13") all["rows"] = team13_rows(installed);
  if (only.empty() || only == "ring") all["ring"] = ring_rows(installed);
  if (only.empty() || only == "closed_leg") all["closed_leg"] = closed_leg_rows(installed);
  if (only.empty() || only == "relay") all["relay"] = relay_rows(installed);
  return bench::write_json(argc, argv, all);
}
