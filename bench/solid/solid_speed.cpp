// Speed of explicit finite elements: cell-steps a second and core of CPU time, the share of contact, beside CalculiX.
//   bench_solid_speed [--json PATH]

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/solid/ccx_peer.h"
#include "core/cpu_time.h"

namespace {

using namespace powbench;
using namespace powbench::sim;

/// Million cell-steps a second: the best of several runs of `steps`, because others use the machine too.
double rate(ExplicitSolid& s, long cells, long steps) {
  s.step();
  double best = 0;
  for (int k = 0; k < 5; ++k) {
    const double start = process_cpu_seconds();
    for (long n = 0; n < steps; ++n) s.step();
    best = std::max(best, static_cast<double>(cells * steps) / (process_cpu_seconds() - start) / 1e6);
  }
  return best;
}

struct Row {
  std::string what;
  long cells = 0;
  double rate = 0, must = 0, goal = 0;
};

SolidOptions quiet(bool in_float) {
  SolidOptions o;
  o.float_forces = in_float;
  o.ledger_every = 0;
  return o;
}

Row bar(const std::string& what, int nx, int nz, bool in_float, bool skewed, bool plastic, double must,
        double goal) {
  SolidMesh mesh;
  const double h = 1e-3;
  add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {nx * h, nx * h, nz * h}, nx, nx, nz);
  if (skewed)
    map_nodes(mesh, 0, [](const Vec3& p) { return Vec3{p.x + 2 * p.y * p.z, p.y, p.z + p.x * p.y}; });
  SolidMaterial m;
  if (plastic) m.yield = 3e8;
  ExplicitSolid s(mesh, {m}, quiet(in_float));
  s.set_velocity(0, {0, 0, -1});
  s.add_plane(0, {0, 0, 0}, {0, 0, 1}, 0.65);
  const long cells = static_cast<long>(mesh.cells.size());
  return {what, cells, rate(s, cells, std::max(20L, 2000000 / cells)), must, goal};
}

/// A bar pressed on a plate, held in contact or free of it.
std::unique_ptr<ExplicitSolid> pressed_bar(bool touching, long* cells) {
  SolidMesh mesh;
  const double h = 1e-3;
  add_box(mesh, mesh.add_part("plate"), {-2 * h, -2 * h, -4 * h}, {12 * h, 12 * h, 0}, 14, 14, 4);
  add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {10 * h, 10 * h, 50 * h}, 10, 10, 50);
  auto s = std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>{SolidMaterial{}, SolidMaterial{}},
                                           quiet(false));
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
    if (mesh.nodes[static_cast<std::size_t>(n)].z < -3.9 * h) s->fix(n, true, true, true);
  s->add_load({s->whole_part(1), {0, 0, -2e5}});  // keeps it pressed
  if (touching) {
    ContactPair pair{0, 1};
    pair.friction_static = 0.3;
    pair.friction_dynamic = 0.2;
    pair.decay = 1;
    s->set_contact({{pair}});
  }
  *cells = static_cast<long>(mesh.cells.size());
  s->step();
  return s;
}

/// The share that contact adds to a step: the median of rounds in which both go by turns, because others use the
/// machine too, over several pairs, because the share depends by some per cent on where their numbers come to lie.
double contact_share(double* with, long* cells) {
  constexpr int pairs = 9, rounds = 11, steps = 60;
  const auto seconds = [&](ExplicitSolid& s) {
    const double start = process_cpu_seconds();
    for (int n = 0; n < steps; ++n) s.step();
    return process_cpu_seconds() - start;
  };
  std::vector<double> shares;
  std::vector<std::unique_ptr<ExplicitSolid>> kept;  // so that the next ones lie elsewhere
  *with = 0;
  for (int pair = 0; pair < pairs; ++pair) {
    kept.push_back(pressed_bar(false, cells));
    kept.push_back(pressed_bar(true, cells));
    for (int k = 0; k < rounds; ++k) {
      const double without = seconds(*kept[kept.size() - 2]), touching = seconds(*kept.back());
      shares.push_back(touching / without - 1);
      *with = std::max(*with, static_cast<double>(*cells * steps) / touching / 1e6);
    }
  }
  std::nth_element(shares.begin(), shares.begin() + pairs * rounds / 2, shares.end());
  return shares[pairs * rounds / 2];
}

}  // namespace

int main(int argc, char** argv) {
  std::string json_path;
  for (int i = 1; i + 1 < argc; i += 2)
    if (std::strcmp(argv[i], "--json") == 0) json_path = argv[i + 1];
  std::vector<Row> rows;
  rows.push_back(bar("bricks, double", 16, 20, false, false, false, 30, 36));
  rows.push_back(bar("bricks, float forces", 16, 20, true, false, false, 55, 64));
  rows.push_back(bar("distorted hexahedra, double", 16, 20, false, true, false, 30, 36));
  rows.push_back(bar("distorted hexahedra, float forces", 16, 20, true, true, false, 55, 64));
  rows.push_back(bar("plastic hexahedra, double", 16, 20, false, false, true, 0, 30));
  rows.push_back(bar("bricks, double, 65 thousand", 32, 64, false, false, false, 0, 30));
  rows.push_back(bar("bricks, double, 512 thousand", 64, 125, false, false, false, 0, 23));
  double with = 0;
  long cells = 0;
  const double share = contact_share(&with, &cells);
  rows.push_back({"bar pressed on a plate, contact with friction", cells, with, 0, 0});

  std::printf("Explicit steps of hexahedra, time integration included, one core, instructions: %s\n",
              best_cell_kernel().name);
  std::printf("%-46s %8s %12s %6s %6s\n", "mesh", "cells", "M steps/s", "must", "goal");
  auto list = nlohmann::ordered_json::array();
  const auto print = [&](const Row& r) {
    const auto or_dash = [](double x) {
      return x > 0 ? std::to_string(static_cast<int>(x)) : std::string("-");
    };
    std::printf("%-46s %8ld %12.2f %6s %6s\n", r.what.c_str(), r.cells, r.rate, or_dash(r.must).c_str(),
                or_dash(r.goal).c_str());
    list.push_back({{"mesh", r.what},
                    {"cells", r.cells},
                    {"million_cell_steps_per_s", r.rate},
                    {"must", r.must},
                    {"goal", r.goal}});
  };
  for (const Row& r : rows) print(r);
  std::printf("contact adds %.1f %% to the step (must <= 15 %%)\n", 100 * share);
  if (bench::ccx_is_here()) {
    for (const char* contact : {"tied", "n2s", "s2s"}) {
      const double end = std::strcmp(contact, "s2s") == 0 ? 1e-5 : 4e-5;
      const auto run = bench::run_ccx(bench::ccx_bar(contact, end));
      if (!run.ran || run.selected <= 0) {
        std::printf("CalculiX %s: did not finish\n", contact);
        continue;
      }
      const double rate_ccx = 5000 * end / run.selected / run.cpu / 1e6;
      print({std::string("CalculiX C3D8R, ") + contact, 5000, rate_ccx, 0, 0});
      std::printf("    powbench over CalculiX: %.0f\n",
                  (std::strcmp(contact, "tied") == 0 ? rows[0].rate : with) / rate_ccx);
    }
  } else {
    std::printf("CalculiX: not installed, no peer in this run\n");
  }
  if (!json_path.empty()) {
    std::ofstream out(json_path);
    out << nlohmann::ordered_json{{"benchmark", "solid_speed"},
                                  {"instructions", best_cell_kernel().name},
                                  {"contact_share", share},
                                  {"rows", list}}
               .dump(2)
        << '\n';
    if (!out) {
      std::fprintf(stderr, "solid_speed: cannot write %s\n", json_path.c_str());
      return 2;
    }
  }
  return 0;
}
