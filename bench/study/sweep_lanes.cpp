// Closings side by side in lanes against the same closings one by one: CPU time of each, and by how much they differ.
// The reference specimen at angles and voltages of a sweep, and devices that are each another one. One thread;
// both are timed by turns, the median of the turns stands.
//   bench_sweep_lanes [--json PATH] [--scenes N] [--turns N]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/models/lanes/lane_block.h"
#include "sim/models/lanes/plant_lanes.h"
#include "sim/study/axis.h"

namespace {

using namespace powbench::sim;

constexpr double duration = 0.05, tolerance = 1e-5;  // those of `powbench sweep`

double cpu() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

Plant plant_of(const Case& c) {
  return closing_plant(c.specimen, c.conditions, tolerance, c.bench);
}

using Events = std::vector<PlantEvent>;
Events copied(const Plant& p) {
  return {p.events().begin(), p.events().end()};
}

std::vector<Events> alone(const std::vector<Case>& cases) {
  std::vector<Events> all;
  for (const Case& c : cases) {
    Plant p = plant_of(c);
    p.advance(duration, {}, {});
    all.push_back(copied(p));
  }
  return all;
}

std::vector<Events> in_lanes(const std::vector<Case>& cases, LaneKernel kernel) {
  std::vector<Events> all(cases.size());
  struct Running {
    std::size_t index;
    Plant plant;
  };
  std::vector<std::unique_ptr<Running>> running;
  std::size_t next = 0;
  advance_in_lanes(
      [&]() -> LaneRun {
        if (next == cases.size()) return {};
        running.push_back(std::make_unique<Running>(Running{next, plant_of(cases[next])}));
        ++next;
        return {&running.back()->plant, duration};
      },
      [&](Plant& plant) {
        const auto at =
            std::find_if(running.begin(), running.end(), [&](const auto& r) { return &r->plant == &plant; });
        all[(*at)->index] = copied(plant);
        running.erase(at);
      },
      {}, kernel);
  return all;
}

/// Those that this processor can run, the fastest first.
struct Named {
  const char* name;
  LaneKernel kernel;
};
std::vector<Named> kernels() {
  std::vector<Named> list;
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    list.push_back({"AVX-512", avx512_lane_kernel});
  if (__builtin_cpu_supports("avx2")) list.push_back({"AVX2", avx2_lane_kernel});
#endif
  list.push_back({"portable", portable_lane_kernel});
  return list;
}

struct Row {
  const char *cases = "", *kernel = "";
  std::size_t count = 0, known = 0, other = 0;
  double one = 0, side_by_side = 0, largest = 0;  ///< ms a closing, ms, us
};

/// us; infinite where the events are others.
double difference(const Events& a, const Events& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].kind != b[i].kind) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, 1e6 * std::fabs(a[i].time - b[i].time));
  }
  return largest;
}

/// Those that can be integrated at all, and how many of them the lanes know.
std::vector<Case> usable(const std::vector<Case>& drawn, std::size_t& known) {
  std::vector<Case> cases;
  known = 0;
  for (const Case& c : drawn) {
    try {
      Plant p = plant_of(c);
      p.advance(duration, {}, {});
    } catch (const std::exception&) {
      continue;
    }
    cases.push_back(c);
    ContactorModel model(c.specimen, closing_mains(c.conditions), closing_options(c.conditions));
    ContactorModel::State s = model.rest();
    model.set_coil(0, s.data(), true);
    LaneLayout layout;
    known += model.lane_layout(layout) ? 1U : 0U;
  }
  return cases;
}

/// A row for each kernel; those alone are timed by turns with the first of them.
std::vector<Row> measured(const char* name, const std::vector<Case>& drawn, int turns) {
  std::vector<Row> rows;
  std::size_t known = 0;
  const std::vector<Case> cases = usable(drawn, known);
  const auto each = 1e3 / static_cast<double>(cases.size());
  std::vector<double> one;
  std::vector<Events> a, b;
  for (const Named& k : kernels()) {
    Row row{name, k.name, cases.size(), known};
    std::vector<double> together;
    for (int turn = 0; turn < turns; ++turn) {
      const double start = cpu();
      if (rows.empty()) a = alone(cases);
      const double middle = cpu();
      b = in_lanes(cases, k.kernel);
      if (rows.empty()) one.push_back(each * (middle - start));
      together.push_back(each * (cpu() - middle));
    }
    row.one = median(one), row.side_by_side = median(together);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double d = difference(a[i], b[i]);
      row.other += d != 0 ? 1U : 0U;
      row.largest = std::max(row.largest, d);
    }
    rows.push_back(row);
  }
  return rows;
}

std::vector<Case> sweep(int count) {
  powbench::Random random(7);
  std::vector<Case> cases(static_cast<std::size_t>(count));
  for (Case& c : cases) {
    c.conditions.closing_angle = powbench::pi * random.uniform();
    c.conditions.supply_volts = 230 + 6 * (random.uniform() - 0.5);
  }
  return cases;
}

/// Another device each: numbers spread about the reference, one in five tilted, one in five with unequal poles, one in
/// five with its static core on a buffer, one in ten without a ring.
std::vector<Case> devices(int count) {
  powbench::Random random(41);
  std::vector<Case> cases(static_cast<std::size_t>(count));
  for (Case& c : cases) {
    Specimen& s = c.specimen;
    const auto spread = [&](double share, auto&... numbers) {
      ((numbers *= 1 + share * (2 * random.uniform() - 1)), ...);
    };
    spread(0.3, s.core.mass, s.core.return_preload, s.core.return_rate, s.core.stop_stiffness,
           s.bridges.preload, s.bridges.rate, s.bridges.mass, s.bridges.contact_stiffness, s.magnet.pole_area,
           s.magnet.residual_gap);
    spread(0.9, s.core.friction, s.base.hertz, s.base.damping);
    spread(0.2, s.bridges.gap, s.coil.resistance, s.coil.leakage);
    const double shape = random.uniform();
    if (shape < 0.2) s.bridges.tilt_gap = 0.2e-3 * random.uniform();
    if (shape > 0.2 && shape < 0.4) s.bridges.gap_spread = 0.1e-3 * random.uniform();
    if (shape > 0.4 && shape < 0.6) s.base.core_mass = 0.08 * random.uniform() + 0.02;
    if (shape > 0.9) s.magnet.shaded_share = 0;
    c.conditions.closing_angle = 2 * powbench::pi * random.uniform();
    c.conditions.supply_volts = 170 + 90 * random.uniform();
    c.conditions.mains_hertz = 45 + 20 * random.uniform();
    c.conditions.ambient = powbench::zero_celsius - 5 + 65 * random.uniform();
  }
  return cases;
}

}  // namespace

int main(int argc, char** argv) {
  const char* json = nullptr;
  int scenes = 100'000, turns = 5;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--json") == 0) json = argv[i + 1];
    if (std::strcmp(argv[i], "--scenes") == 0) scenes = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--turns") == 0) turns = std::atoi(argv[i + 1]);
  }
  std::vector<Row> rows = measured("reference, sweep", sweep(5000), turns);
  for (const Row& r : measured("devices drawn", devices(scenes), 1)) rows.push_back(r);
  std::printf("Closings of %.0f ms at tolerance %g, %d lanes; CPU ms a closing, one thread\n", 1e3 * duration,
              tolerance, lane_width);
  std::printf("%-18s %-9s %8s %10s %8s %10s %7s %8s %14s\n", "closings", "kernel", "number", "in lanes",
              "alone", "in lanes", "ratio", "others", "largest, us");
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  std::size_t others = 0;
  for (const Row& r : rows) {
    others += r.other;
    std::printf("%-18s %-9s %8zu %9.1f%% %8.4f %10.4f %7.2f %8zu %14.3g\n", r.cases, r.kernel, r.count,
                100 * static_cast<double>(r.known) / static_cast<double>(r.count), r.one, r.side_by_side,
                r.one / r.side_by_side, r.other, r.largest);
    out.push_back({{"closings", r.cases},
                   {"kernel", r.kernel},
                   {"number", r.count},
                   {"known_to_the_lanes", r.known},
                   {"alone_ms", r.one},
                   {"in_lanes_ms", r.side_by_side},
                   {"other_events", r.other},
                   {"largest_difference_us", r.largest}});
  }
  if (json != nullptr) std::ofstream(json) << out.dump(1) << '\n';
  return others == 0 ? 0 : 1;
}
