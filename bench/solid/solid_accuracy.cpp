// Errors of explicit finite elements against closed solutions, and Taylor's bar beside CalculiX in the same run.
//   bench_solid_accuracy [--json PATH]

#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/solid/ccx_peer.h"
#include "bench/solid/impact_cases.h"

namespace {

using namespace powbench::bench;

nlohmann::ordered_json list = nlohmann::ordered_json::array();

/// One line: what came out, what was expected, the error in per cent, what it may be.
void line(const std::string& what, double value, double expected, const char* unit, double must) {
  const double error = 100 * (value / expected - 1);
  std::printf("%-58s %12.5g %12.5g %-6s %+8.3f", what.c_str(), value, expected, unit, error);
  if (must > 0)
    std::printf("  <= %-6g %s\n", must, std::fabs(error) <= must ? "holds" : "MISSED");
  else
    std::printf("\n");
  list.push_back({{"case", what},
                  {"value", value},
                  {"expected", expected},
                  {"unit", unit},
                  {"error_percent", error},
                  {"must_percent", must}});
}

void bars() {
  for (const int cells : {50, 100, 200}) {
    const BarOnWall r = bar_on_wall(cells, 0.95, 0.65);
    const std::string name = "bar on wall, nu = 0, " + std::to_string(cells) + " cells: ";
    line(name + "contact time over 2 L / c", 1 + r.contact_error, 1, "", cells == 100 ? 1.5 : 0);
    line(name + "kinetic energy after, lowest", r.kinetic_low, 1, "", cells == 100 ? 0.05 : 0);
    line(name + "kinetic energy after, highest", r.kinetic_high, 1, "", cells == 100 ? 0.05 : 0);
    std::printf("    hourglass %.1e of strain energy (must < 1e-2), energy residual %.1e\n", r.hourglass,
                r.residual);
  }
  const BarOnWall plain = bar_on_wall(100, 0.9, 1);
  std::printf(
      "    for comparison, 100 cells with step 0.9 and plane 1: contact time %+.2f %%, kinetic energy %.5f "
      ".. %.5f\n",
      100 * plain.contact_error, plain.kinetic_low, plain.kinetic_high);
  for (const int cells : {100, 400}) {
    const ConfinedBar r = confined_bar(cells);
    const std::string name = "confined bar (SDNV100), " + std::to_string(cells) + " cells: ";
    line(name + "touch", 1e6 * r.touch, 20, "us", 0);
    line(name + "release", 1e6 * r.leave, 88.951, "us", 0);
    line(name + "stress", 1e-6 * r.plateau, 4640.95, "MPa", 0);
    line(name + "speed of the front", r.front, 5801.19, "m/s", 0);
  }
  for (const bool meet : {true, false}) {
    const TwoBars r = two_bars(meet);
    const std::string name = meet ? "two equal bars, nodes meet: " : "two equal bars, nodes apart: ";
    line(name + "contact time over 2 L / c", 1 + r.contact_error, 1, "", 0);
    line(name + "velocity of the struck one", r.v_second, 1, "", 0);
    line(name + "force", 1 + r.force_error, 1, "", 0);
  }
  for (const int through : {2, 4, 8})
    line("cantilever L/h = 20, " + std::to_string(through) + " cells high: frequency",
         1 + cantilever_error(through, 20), 1, "", through == 4 ? 3 : 0);
  for (const double share : {0.5, 2.0})
    line("cantilever, 4 cells high, hourglass stiffness x " + std::string(share < 1 ? "0.5" : "2") +
             ": frequency",
         1 + cantilever_error(4, 20, share), 1, "", 0);
}

/// Our finest mesh beside quadratic elements of reduced integration, on a mesh of their own.
void beside_calculix(const TaylorBar& own) {
  if (!ccx_is_here()) {
    std::printf("    CalculiX: not installed, no peer in this run\n");
    return;
  }
  std::vector<std::array<int, 20>> cells;
  const auto mesh = with_middles(taylor_mesh(1, 20), 3.2e-3, cells);
  const CcxTaylor peer = read_taylor(mesh, run_ccx(ccx_taylor(mesh, cells, 3e-7)));
  if (!peer.ran) {
    std::printf("    CalculiX did not finish\n");
    return;
  }
  std::printf(
      "    CalculiX, %zu C3D20R, implicit: length %.3f mm, radius %.3f mm, plastic strain %.2f, %.1f s CPU\n",
      cells.size(), 1e3 * peer.length, 1e3 * peer.radius, peer.plastic_strain, peer.cpu);
  line("Taylor bar beside CalculiX: length", 1e3 * own.length, 1e3 * peer.length, "mm", 1);
  line("Taylor bar beside CalculiX: radius of the foot", 1e3 * own.radius, 1e3 * peer.radius, "mm", 3);
  line("Taylor bar beside CalculiX: peak plastic strain", own.plastic_strain, peer.plastic_strain, "", 15);
}

void taylor() {
  const int across = 3, along = 40;
  std::clock_t start = std::clock();
  const TaylorBar own = taylor_bar(across, along, true);
  const double cpu = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf(
      "Taylor bar, 1080 cells, foot held: length %.3f mm, radius %.3f mm, plastic strain %.2f, energy "
      "residual %.1e, "
      "%.1f s CPU\n",
      1e3 * own.length, 1e3 * own.radius, own.plastic_strain, own.residual, cpu);
  TaylorBar finest;
  for (const int finer : {4, 5}) {
    const TaylorBar r = taylor_bar(finer, along * finer / across, true);
    std::printf(
        "    %d instead of %d cells to the radius: length %.3f mm, radius %.3f mm, plastic strain %.2f\n",
        finer, across, 1e3 * r.length, 1e3 * r.radius, r.plastic_strain);
    finest = r;
  }
  beside_calculix(finest);
  for (const double share : {0.3, 0.5, 2.0}) {
    const TaylorBar r = taylor_bar(across, along, true, TaylorCells::hexahedra, share);
    std::printf(
        "    hourglass stiffness %.2f of the bending one instead of 0.1: length %.3f mm, radius %.3f mm, "
        "plastic strain %.2f\n",
        0.1 * share, 1e3 * r.length, 1e3 * r.radius, r.plastic_strain);
  }
  const TaylorBar tets = taylor_bar(across, along, true, TaylorCells::tetrahedra);
  std::printf(
      "    12 960 tetrahedra instead: length %.3f mm (%+.2f %%), radius %.3f mm (%+.1f %%), plastic strain "
      "%.2f, "
      "energy residual %.1e\n",
      1e3 * tets.length, 100 * (tets.length / own.length - 1), 1e3 * tets.radius,
      100 * (tets.radius / own.radius - 1), tets.plastic_strain, tets.residual);
  const TaylorBar free = taylor_bar(across, along, false);
  std::printf(
      "    foot free to leave the wall: length %.3f mm, radius %.3f mm (published codes 21.3 .. 21.7 and 6.9 "
      ".. 7.2)\n",
      1e3 * free.length, 1e3 * free.radius);
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path;
  for (int i = 1; i + 1 < argc; i += 2)
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
  std::printf("%-58s %12s %12s %-6s %8s  %s\n", "case", "value", "expected", "unit", "error %", "must %");
  bars();
  const SphereImpact sphere = sphere_on_half_space(0.1e-3, 1);
  line("sphere on half-space, 0.1 mm: depth", 1e6 * sphere.depth, 23.4808, "um", 3);
  line("sphere on half-space, 0.1 mm: force", sphere.force, 1750.47, "N", 3);
  line("sphere on half-space, 0.1 mm: time", 1e6 * sphere.time, 69.110, "us", 3);
  const CylinderContact roll = cylinder_on_block(0.5e-3);
  line("cylinder on block, 0.5 mm: half width of contact", 1e3 * roll.half_width, 6.2146, "mm", 0);
  line("cylinder on block, 0.5 mm: pressure", 1e-6 * roll.pressure, 3585.4, "MPa", 0);
  taylor();
  if (!json_path.empty()) {
    std::ofstream out(json_path);
    out << nlohmann::ordered_json{{"benchmark", "solid_accuracy"}, {"rows", list}}.dump(2) << '\n';
    if (!out) {
      std::fprintf(stderr, "solid_accuracy: cannot write %s\n", json_path.c_str());
      return 2;
    }
  }
  return 0;
}
