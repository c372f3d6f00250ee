#include "bench/space/team13_rows.h"

#include <cmath>
#include <cstdio>

#include "bench/space/probe.h"
#include "bench/space/team13.h"
#include "core/cpu_time.h"
#include "sim/magnetics/space/newton.h"

namespace powbench::bench {

namespace {

constexpr double published_gap = 0.5e-3;

/// The problem by the scalar potential, from above.
class Team13Above {
 public:
  Team13Above(double size, double gap)
      : gap_(gap), problem_(team13(size, gap)), space_(problem_), newton_(space_) {}

  sim::space::Solution solve(double ampere_turns) { return newton_.solve({{false, ampere_turns}}); }
  /// At 1000 A; the cost is that of the solution alone.
  Team13Bound bound() {
    const double start = process_cpu_seconds();
    const auto s = solve(1000);
    const double cost = process_cpu_seconds() - start;
    Team13Bound out{"above", gap_, 2, space_.unknowns(), s.iterations, cost, s.flux[0]};
    for (const auto& row : team13_plate)
      out.plate.push_back(team13_plate_average(space_, s.state, row.z_mm * 1e-3));
    return out;
  }
  const sim::space::Coenergy& space() const { return space_; }

 private:
  double gap_;
  sim::space::Problem problem_;
  sim::space::Coenergy space_;
  sim::space::Newton newton_;
};

/// With the cost of mesh and matrices, as from below.
Team13Bound team13_above(double size, double gap) {
  const double start = process_cpu_seconds();
  Team13Above field(size, gap);
  const double set_up = process_cpu_seconds() - start;
  auto out = field.bound();
  out.cpu += set_up;
  return out;
}

Team13Bound team13_below(double size, int order, double gap) {
  const double start = process_cpu_seconds();
  EdgeField field(team13_edges(size, order, gap));
  const auto s = field.solve(1000);
  Team13Bound out{"below", gap, order, field.unknowns(), s.iterations, process_cpu_seconds() - start, s.psi};
  for (const auto& row : team13_plate) out.plate.push_back(team13_plate_average(field, s, row.z_mm * 1e-3));
  return out;
}

}  // namespace

Team13Bound team13_rows(Table& table, double size) {
  Team13Above field(size, published_gap);
  auto above = field.bound();
  for (std::size_t k = 0; k < above.plate.size(); ++k)
    table.add({"TEAM 13, 1000 A, plate z " + std::to_string(static_cast<int>(team13_plate[k].z_mm)) + " mm",
               "T", above.plate[k], team13_plate[k].b, above.unknowns, above.iterations, above.cpu,
               "measured"});
  const double start = process_cpu_seconds();
  const auto strong = field.solve(3000);
  const double cost = process_cpu_seconds() - start;
  const Probe probe(field.space(), strong.state);
  for (const auto& row : team13_air) {
    const auto b = probe.at({row.x_mm * 1e-3, 20e-3, 55e-3}).b;
    table.add({"TEAM 13, 3000 A, air x " + std::to_string(static_cast<int>(row.x_mm)) + " mm", "T",
               std::hypot(b[0], b[1], b[2]), row.b, above.unknowns, strong.iterations, cost, "measured"});
  }
  return above;
}

nlohmann::ordered_json team13_bounds(const Team13Bound& finest, bool fine) {
  std::printf(
      "\nTEAM 13, 1000 A: flux linkage and plate averages from above (scalar potential) and below (edge "
      "elements), "
      "per cent off the measured averages\n%-6s %5s %6s %9s %4s %8s %10s",
      "", "order", "gap mm", "unknowns", "its", "CPU s", "psi mWb");
  for (const auto& row : team13_plate) std::printf(" %4.0f mm", row.z_mm);
  std::printf("\n");
  auto list = nlohmann::ordered_json::array();
  const auto print = [&](const Team13Bound& b) {
    std::printf("%-6s %5d %6.2f %9d %4d %8.2f %10.6f", b.side.c_str(), b.order, b.gap * 1e3, b.unknowns,
                b.iterations, b.cpu, b.psi * 1e3);
    auto errors = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < b.plate.size(); ++k) {
      errors.push_back(100 * (b.plate[k] / team13_plate[k].b - 1));
      std::printf(" %+7.2f", errors.back().get<double>());
    }
    std::printf("\n");
    std::fflush(stdout);
    list.push_back({{"side", b.side},
                    {"order", b.order},
                    {"gap_m", b.gap},
                    {"unknowns", b.unknowns},
                    {"iterations", b.iterations},
                    {"cpu_s", b.cpu},
                    {"psi", b.psi},
                    {"plate_error_percent", errors}});
    return b.psi;
  };
  constexpr double gap = published_gap, wider = 0.58e-3;
  print(team13_below(2.5, 1, gap));
  double low = 0;
  for (const double size : fine ? std::vector<double>{5, 2.5, 1.6} : std::vector<double>{5, 2.5}) {
    if (size > 2) print(team13_above(size, gap));
    low = print(team13_below(size, 2, gap));
  }
  const double high = print(finest);
  std::printf("the flux linkage lies between %.4f and %.4f mWb, %.2f %% apart\n", low * 1e3, high * 1e3,
              100 * (high / low - 1));
  print(team13_above(2.5, wider));
  print(team13_below(5, 2, wider));
  return list;
}

}  // namespace powbench::bench
