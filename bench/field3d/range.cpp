// The reference contactor on every rung of the fields, over the whole range of current and gap: flux linkage and pull
// of the magnetic circuit, of the plane rung, of the plane table with the ends of three dimensions, beside three
// dimensions.
//   field_range [--json PATH] [--fine]      --fine: finer cells in three dimensions (minutes)

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/cpu_time.h"
#include "sim/field3d/end_table.h"
#include "sim/fields/circuit.h"

namespace {

namespace sim = powbench::sim;
using Json = nlohmann::ordered_json;

/// One state of one rung: flux linkage of the coil and pull at a given current, the ring without current.
struct State {
  double psi = 0, pull = 0;
};

/// The fluxes at which a potential's currents are these: Newton on its convex energy, halved until W - i psi falls.
State at_current(const sim::MagneticPotential& w, double current, double gap) {
  sim::MagneticState x{0, 0, gap};
  const auto height = [&](const sim::MagneticState& s) { return w.at(s).energy - current * s.psi; };
  for (int k = 0; k < 200; ++k) {
    const auto r = w.at(x);
    const double a = r.current - current, b = w.has_ring() ? r.ring_current : 0;
    const double ring = w.has_ring() ? r.ring_ring : 1;
    const double det = r.current_psi * ring - r.current_ring * r.current_ring;
    const double dp = -(a * ring - b * r.current_ring) / det,
                 ds = -(b * r.current_psi - a * r.current_ring) / det;
    double share = 1;
    const double from = height(x);
    while (share > 1e-6 && height({x.psi + share * dp, x.ring + share * ds, gap}) > from) share /= 2;
    x.psi += share * dp;
    x.ring += share * ds;
    if (std::fabs(dp) < 1e-12 * (std::fabs(x.psi) + 1e-12)) break;
  }
  return {x.psi, w.at(x).pull};
}

constexpr const char* names[] = {"circuit", "field2d", "table of field2d with ends"};
constexpr std::size_t rungs = std::size(names);

struct Worst {
  double psi = 0, pull = 0, psi_sum = 0, pull_sum = 0;
  int count = 0;
  void add(double a, double b) {
    psi = std::max(psi, std::fabs(a));
    pull = std::max(pull, std::fabs(b));
    psi_sum += a * a;
    pull_sum += b * b;
    ++count;
  }
};

bool write(const std::string& path, const Json& all) {
  if (path.empty()) return true;
  std::ofstream out(path);
  out << all.dump(2) << '\n';
  if (out) return true;
  std::fprintf(stderr, "field_range: cannot write %s\n", path.c_str());
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path;
  bool fine = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json_path = argv[++i];
    else if (std::strcmp(argv[i], "--fine") == 0)
      fine = true;
  }
  const sim::MagnetDesign design;
  std::map<std::string, double> cost;
  double start = powbench::process_cpu_seconds();
  const auto stop = [&](const char* name) {
    cost[name] += powbench::process_cpu_seconds() - start;
    start = powbench::process_cpu_seconds();
  };
  sim::TableOptions options;
  options.largest_field = 3.5;  // T: the closed core at 2 A
  sim::Team team(1);
  const sim::TablePotential table(sim::build_table_with_ends(design, options, {}, team));
  stop("table");
  sim::MagnetDesign leaky = design;  // the heads' leakage as the two plane rungs take it: one number
  leaky.end_leakage =
      sim::end_corrections(design, sim::EndTableOptions{}.sizes, 0.05, {2e-3}).front().leakage;
  const sim::CircuitPotential circuit(design.shape, design.steel, design.turns, design.residual_gap,
                                      leaky.end_leakage);
  sim::MagnetField plane(leaky, sim::plan_table(leaky, options).field);
  sim::CoreMeshSizes3 sizes = sim::CoreMeshSizes3{}.scaled(fine ? 1.4 : 2);
  sizes.corner = sim::CoreMeshSizes3{}.corner;  // what small gaps need; the other cells hold 0.3 %
  sim::MagnetField3 whole(design, sizes);
  std::printf(
      "The reference contactor, ring without current. Deviations from field3d (%d unknowns), per cent.\n",
      whole.unknowns());
  std::printf("%7s %6s | %10s %10s | %8s %8s | %8s %8s | %8s %8s\n", "", "", "field3d", "field3d", "circuit",
              "circuit", "field2d", "field2d", "2d+ends", "2d+ends");
  std::printf("%7s %6s | %10s %10s | %8s %8s | %8s %8s | %8s %8s\n", "gap mm", "i A", "psi Wb", "pull N",
              "psi", "pull", "psi", "pull", "psi", "pull");
  Json rows = Json::array();
  Worst worst[rungs];
  for (const double gap : {6e-3, 4e-3, 2e-3, 0.5e-3, 0.1e-3, 0.0}) {
    start = powbench::process_cpu_seconds();
    plane.set_gap(gap);
    whole.set_gap(gap);
    for (const double current : {0.03, 0.3, 0.7, 1.2, 2.0}) {
      start = powbench::process_cpu_seconds();
      const auto p3 = whole.at_current(current);
      stop("field3d");
      const auto p2 = plane.at_current(current, 0);
      stop(names[1]);
      const State found[rungs] = {at_current(circuit, current, gap),
                                  {plane.fluxes(p2).first, p2.response.pull},
                                  at_current(table, current, gap)};
      std::printf("%7.2f %6.2f | %10.6f %10.4f |", gap * 1e3, current, p3.psi, p3.response.pull);
      Json row{{"gap_m", gap}, {"current_a", current}, {"psi", p3.psi}, {"pull", p3.response.pull}};
      for (std::size_t r = 0; r < rungs; ++r) {
        const double psi = 100 * (found[r].psi / p3.psi - 1),
                     pull = 100 * (found[r].pull / p3.response.pull - 1);
        worst[r].add(psi, pull);
        std::printf(" %+8.2f %+8.2f%s", psi, pull, r + 1 < rungs ? " |" : "\n");
        row[names[r]] = {{"psi_percent", psi}, {"pull_percent", pull}};
      }
      rows.push_back(row);
    }
  }
  Json summary = Json::array();
  std::printf("\n%-28s %10s %10s %10s %10s\n", "deviation from field3d, %", "psi rms", "psi worst",
              "pull rms", "pull worst");
  for (std::size_t r = 0; r < rungs; ++r) {
    const auto& w = worst[r];
    const double psi_rms = std::sqrt(w.psi_sum / w.count), pull_rms = std::sqrt(w.pull_sum / w.count);
    std::printf("%-28s %10.2f %10.2f %10.2f %10.2f\n", names[r], psi_rms, w.psi, pull_rms, w.pull);
    summary.push_back({{"rung", names[r]},
                       {"psi_rms_percent", psi_rms},
                       {"psi_worst_percent", w.psi},
                       {"pull_rms_percent", pull_rms},
                       {"pull_worst_percent", w.pull}});
  }
  std::printf(
      "\nCPU: a state of field3d %.0f times one of field2d; the table with ends (%s) as long as %.0f states "
      "of "
      "field3d\n",
      cost["field3d"] / cost[names[1]], table.table().description.c_str(),
      cost["table"] / (cost["field3d"] / static_cast<double>(rows.size())));
  return write(json_path, {{"benchmark", "field_range"}, {"rows", rows}, {"summary", summary}}) ? 0 : 2;
}
