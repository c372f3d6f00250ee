#include "bench/field3d/team13_rows.h"

#include <cmath>
#include <cstdio>

#include "bench/field3d/probe3.h"
#include "bench/field3d/team13.h"
#include "core/cpu_time.h"
#include "sim/field3d/newton3.h"

namespace powbench::bench {

Bound team13(Table& table, double size) {
  const auto p = team13(size);
  const sim::Coenergy3 w(p);
  sim::Newton3 newton(w);
  const double start = process_cpu_seconds();
  const auto s = newton.solve({{false, 1000}});
  Bound above{"above", 0.5e-3, 2, w.unknowns(), s.iterations, process_cpu_seconds() - start, s.flux[0]};
  for (const auto& row : team13_plate) {
    above.plate.push_back(team13_plate_average(w, s.state, row.z_mm * 1e-3));
    table.add({"TEAM 13, 1000 A, plate z " + std::to_string(static_cast<int>(row.z_mm)) + " mm", "T",
               above.plate.back(), row.b, w.unknowns(), s.iterations, above.cpu, "measured"});
  }
  const double again = process_cpu_seconds();
  const auto strong = newton.solve({{false, 3000}});
  const double strong_cost = process_cpu_seconds() - again;
  const Probe3 probe(w, strong.state);
  for (const auto& row : team13_air) {
    const auto b = probe.at({row.x_mm * 1e-3, 20e-3, 55e-3}).b;
    table.add({"TEAM 13, 3000 A, air x " + std::to_string(static_cast<int>(row.x_mm)) + " mm", "T",
               std::hypot(b[0], b[1], b[2]), row.b, w.unknowns(), strong.iterations, strong_cost,
               "measured"});
  }
  return above;
}

namespace {

Bound team13_above(double size, double gap) {
  const double start = process_cpu_seconds();
  const auto p = team13(size, gap);
  const sim::Coenergy3 w(p);
  sim::Newton3 newton(w);
  const auto s = newton.solve({{false, 1000}});
  Bound out{"above", gap, 2, w.unknowns(), s.iterations, process_cpu_seconds() - start, s.flux[0]};
  for (const auto& row : team13_plate) out.plate.push_back(team13_plate_average(w, s.state, row.z_mm * 1e-3));
  return out;
}

Bound team13_below(double size, int order, double gap) {
  const double start = process_cpu_seconds();
  EdgeField3 field(team13_edges(size, order, gap));
  const auto s = field.solve(1000);
  Bound out{"below", gap, order, field.unknowns(), s.iterations, process_cpu_seconds() - start, s.psi};
  for (const auto& row : team13_plate) out.plate.push_back(team13_plate_average(field, s, row.z_mm * 1e-3));
  return out;
}

}  // namespace

nlohmann::ordered_json team13_bounds(const Bound& finest, bool fine) {
  std::printf(
      "\nTEAM 13, 1000 A: flux linkage and plate averages from above (scalar potential) and below (edge "
      "elements), "
      "per cent off the measured averages\n%-6s %5s %6s %9s %4s %8s %10s",
      "", "order", "gap mm", "unknowns", "its", "CPU s", "psi mWb");
  for (const auto& row : team13_plate) std::printf(" %4.0f mm", row.z_mm);
  std::printf("\n");
  auto list = nlohmann::ordered_json::array();
  const auto print = [&](const Bound& b) {
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
  constexpr double gap = 0.5e-3, wider = 0.58e-3;
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
