// The reference contactor on every rung of the fields, over the whole range of current and gap: flux linkage and pull
// of the magnetic circuit, of the plane rung, of the plane table with the ends of three dimensions, beside three
// dimensions.
//   field_range [--json PATH] [--fine] [--ring]
//     --fine: finer cells in three dimensions (minutes)
//     --ring: states with current in the shading ring instead, and the table of three variables (ten minutes)

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/fields/circuit.h"
#include "core/cpu_time.h"
#include "sim/magnetics/space/end_table.h"

namespace {

namespace sim = powbench::sim;
using Json = nlohmann::ordered_json;

/// One state of one rung: flux linkages of coil and ring, and pull, at given currents.
struct State {
  double psi = 0, pull = 0, ring = 0;
};

/// The fluxes at which a potential's currents are these: Newton on its convex energy, halved until W - sum i psi falls.
State at_current(const sim::MagneticPotential& w, double current, double gap, double ring_current = 0) {
  sim::MagneticState x{0, 0, gap};
  const auto height = [&](const sim::MagneticState& s) {
    return w.at(s).energy - current * s.psi - ring_current * s.ring;
  };
  for (int k = 0; k < 200; ++k) {
    const auto r = w.at(x);
    const double a = r.current - current, b = w.has_ring() ? r.ring_current - ring_current : 0;
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
  return {x.psi, w.at(x).pull, x.ring};
}

/// base + plus - minus, the last two without a ring: what a table with ends knew before the ring was a variable of it.
class WithoutRingEnds final : public sim::MagneticPotential {
 public:
  WithoutRingEnds(sim::TablePotential base, sim::TablePotential plus, sim::TablePotential minus)
      : base_(std::move(base)), plus_(std::move(plus)), minus_(std::move(minus)) {}
  bool has_ring() const override { return true; }
  sim::MagneticResponse at(const sim::MagneticState& s) const override {
    auto r = base_.at(s);
    const auto a = plus_.at(s), b = minus_.at(s);
    r.energy += a.energy - b.energy;
    r.current += a.current - b.current;
    r.pull += a.pull - b.pull;
    r.current_psi += a.current_psi - b.current_psi;
    return r;
  }

 private:
  sim::TablePotential base_, plus_, minus_;
};

constexpr const char* names[] = {"circuit", "plane", "table of the plane with ends"};
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

/// Three rungs at states with ring current: 0.3 .. 1 of its share of the legs' flux.
Json ring_states(const sim::MagnetDesign& design, const sim::space::CoreMeshSizes& sizes) {
  double start = powbench::process_cpu_seconds();
  const auto seconds = [&] {
    const double from = std::exchange(start, powbench::process_cpu_seconds());
    return start - from;
  };
  sim::TableOptions options, open;
  open.ring = false;
  sim::Team team(1);
  const sim::TablePotential with(sim::build_table_with_ends(design, options, {}, team));
  const double with_cost = seconds();
  sim::TablePotential two(sim::build_table_with_ends(design, open, {}, team));
  const double two_cost = seconds();
  sim::TablePotential flat(sim::build_table(design, options, team));
  const double flat_cost = seconds();
  std::printf("CPU s: table with ends and ring %.0f, with ends %.0f, plane with ring %.0f\n", with_cost,
              two_cost, flat_cost);
  std::printf("with ends and ring: %s\n", with.table().description.c_str());
  const WithoutRingEnds before(std::move(flat), std::move(two),
                               sim::TablePotential(sim::build_table(design, open, team)));
  const auto heads = sim::space::end_corrections(design, sim::EndTableOptions{}.sizes, 0.05, {2e-3}).front();
  sim::MagnetDesign leaky = design;
  leaky.end_leakage = heads.leakage;
  leaky.ring_leakage = heads.ring_leakage;
  std::printf("leakage of the heads: coil %.4f H, ring %.3e H\n", heads.leakage, heads.ring_leakage);
  sim::MagnetField plane(leaky, sim::plan_table(leaky, options).field);
  sim::space::MagnetField whole(design, sizes);
  const auto& s = design.shape;
  const double iron = s.centre_width * s.stack * s.stack_factor;
  constexpr const char* kinds[] = {"plane, leakages in series", "ends of the open ring", "ends and ring"};
  std::printf(
      "\nDeviations from the field in space (%d unknowns) at equal currents, per cent; ring: of its share of "
      "the "
      "flux.\n",
      whole.unknowns());
  std::printf("%6s %5s %5s | %8s %8s %9s | %23s | %23s | %23s\n", "", "", "ring /", "", "", "", kinds[0],
              kinds[1], kinds[2]);
  std::printf("%6s %5s %5s | %8s %8s %9s |", "gap mm", "T", "share", "i A", "ring A", "pull N");
  for (int k = 0; k < 3; ++k) std::printf(" %7s %7s %7s%s", "psi", "ring", "pull", k < 2 ? " |" : "\n");
  Json rows = Json::array();
  double sum[3][3] = {}, worst[3][3] = {};
  for (const double gap : {6e-3, 2e-3, 0.5e-3, 0.1e-3, 0.0}) {
    whole.set_gap(gap);
    plane.set_gap(gap);
    for (const double field : {0.3, 0.9, 1.4})
      for (const double part : {0.3, 0.65, 1.0}) {
        const double psi = field * iron * design.turns, all = field * iron * s.ring_share;
        const auto p = whole.at_flux(psi, part * all).response;
        const auto q = plane.at_current(p.current, p.ring_current);
        const auto [flux, ring] = plane.fluxes(q);
        const State found[] = {{flux, q.response.pull, ring},
                               at_current(before, p.current, gap, p.ring_current),
                               at_current(with, p.current, gap, p.ring_current)};
        std::printf("%6.2f %5.1f %5.2f | %8.4f %8.2f %9.3f |", gap * 1e3, field, part, p.current,
                    p.ring_current, p.pull);
        Json row{{"gap_m", gap},           {"field_t", field},         {"ring_share", part},
                 {"current_a", p.current}, {"ring_a", p.ring_current}, {"pull", p.pull}};
        for (int r = 0; r < 3; ++r) {
          const double off[] = {100 * (found[r].psi / psi - 1), 100 * (found[r].ring - part * all) / all,
                                100 * (found[r].pull / p.pull - 1)};
          std::printf(" %+7.2f %+7.2f %+7.2f%s", off[0], off[1], off[2], r < 2 ? " |" : "\n");
          row[kinds[r]] = off;
          for (int k = 0; k < 3; ++k) {
            sum[r][k] += off[k] * off[k];
            worst[r][k] = std::max(worst[r][k], std::fabs(off[k]));
          }
        }
        std::fflush(stdout);
        rows.push_back(row);
      }
  }
  const double state_cost = seconds() / static_cast<double>(rows.size());
  std::printf("\n%-28s %8s %8s %8s %8s %8s %8s\n", "deviation from space, %", "psi rms", "worst", "ring rms",
              "worst", "pull rms", "worst");
  Json summary = Json::array();
  for (int r = 0; r < 3; ++r) {
    Json line{{"rung", kinds[r]}};
    std::printf("%-28s", kinds[r]);
    for (int k = 0; k < 3; ++k) {
      const double rms = std::sqrt(sum[r][k] / static_cast<double>(rows.size()));
      std::printf(" %8.2f %8.2f", rms, worst[r][k]);
      line[k == 0   ? "psi"
           : k == 1 ? "ring"
                    : "pull"] = {{"rms_percent", rms}, {"worst_percent", worst[r][k]}};
    }
    std::printf("\n");
    summary.push_back(line);
  }
  std::printf("\nCPU of a state here: %.2f s\n", state_cost);
  return {{"benchmark", "field_range"},
          {"rows", rows},
          {"summary", summary},
          {"with_ring_cpu_s", with_cost},
          {"without_ring_cpu_s", two_cost},
          {"plane_cpu_s", flat_cost},
          {"end_leakage_h", heads.leakage},
          {"ring_leakage_h", heads.ring_leakage}};
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path;
  bool fine = false, ring = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0 && i + 1 < argc)
      json_path = argv[++i];
    else if (std::strcmp(argv[i], "--fine") == 0)
      fine = true;
    else if (std::strcmp(argv[i], "--ring") == 0)
      ring = true;
  }
  const sim::MagnetDesign design;
  sim::space::CoreMeshSizes sizes = sim::space::CoreMeshSizes{}.scaled(fine ? 1.4 : 2);
  sizes.corner = sim::space::CoreMeshSizes{}.corner;  // what small gaps need; the other cells hold 0.3 %
  if (ring) return write(json_path, ring_states(design, sizes)) ? 0 : 2;
  std::map<std::string, double> cost;
  double start = powbench::process_cpu_seconds();
  const auto stop = [&](const char* name) {
    cost[name] += powbench::process_cpu_seconds() - start;
    start = powbench::process_cpu_seconds();
  };
  sim::TableOptions options;
  options.largest_field = 3.5;  // T: the closed core at 2 A
  options.ring = false;
  sim::Team team(1);
  const sim::TablePotential table(sim::build_table_with_ends(design, options, {}, team));
  stop("table");
  sim::MagnetDesign leaky = design;  // the heads' leakage as the two plane rungs take it: one number
  leaky.end_leakage =
      sim::space::end_corrections(design, sim::EndTableOptions{}.sizes, 0.05, {2e-3}).front().leakage;
  const sim::CircuitPotential circuit(design.shape, design.steel, design.turns, design.residual_gap,
                                      leaky.end_leakage);
  sim::MagnetField plane(leaky, sim::plan_table(leaky, options).field);
  sim::space::MagnetField whole(design, sizes);
  std::printf(
      "The reference contactor, ring without current. Deviations from the field in space (%d unknowns), per "
      "cent.\n",
      whole.unknowns());
  std::printf("%7s %6s | %10s %10s | %8s %8s | %8s %8s | %8s %8s\n", "", "", "space", "space", "circuit",
              "circuit", "plane", "plane", "ends", "ends");
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
      stop("space");
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
  std::printf("\n%-28s %10s %10s %10s %10s\n", "deviation from space, %", "psi rms", "psi worst", "pull rms",
              "pull worst");
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
      "\nCPU: a state in space %.0f times one in the plane; the table with ends (%s) as long as %.0f states "
      "of "
      "in space\n",
      cost["space"] / cost[names[1]], table.table().description.c_str(),
      cost["table"] / (cost["space"] / static_cast<double>(rows.size())));
  return write(json_path, {{"benchmark", "field_range"}, {"rows", rows}, {"summary", summary}}) ? 0 : 2;
}
