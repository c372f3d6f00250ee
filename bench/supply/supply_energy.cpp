// What the energy balance of a switch-on misses, u i = R i^2 + stored + mechanical + ring loss, over the closing
// angles: both models on the specimen's circuit, other rungs of fields under the rigid one, real supplies and
// switches, and the field itself in the loop.
//   supply [--json PATH]

#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/supply/energy_cases.h"

int main(int argc, char** argv) {
  namespace bench = powbench::bench;
  using Json = nlohmann::ordered_json;
  constexpr double step = 15, tolerance = 1e-9;
  Json list = Json::array();
  double plant_cost = 0;
  std::printf("%-34s %-18s %8s %7s %11s %11s %8s %12s %9s\n", "method", "setting", "closings", "seated",
              "supplied J", "residual", "limit", "CPU ms each", "to plant");
  const auto show = [&](const bench::EnergyRow& r) {
    if (plant_cost == 0) plant_cost = r.cpu_ms;
    const bool holds = r.residual <= r.limit;
    std::printf("%-34s %-18s %8d %7d %11.3f %11.1e %8.0e %12.2f %9.2f%s\n", r.method.c_str(),
                r.setting.c_str(), r.closings, r.seated, r.supplied, r.residual, r.limit, r.cpu_ms,
                r.cpu_ms / plant_cost, holds ? "" : "  MISSED");
    std::fflush(stdout);
    list.push_back({{"method", r.method},
                    {"setting", r.setting},
                    {"closings", r.closings},
                    {"seated", r.seated},
                    {"least_supplied_J", r.supplied},
                    {"worst_residual", r.residual},
                    {"limit", r.limit},
                    {"cpu_ms", r.cpu_ms}});
  };
  for (const auto& r : bench::circuit_rows(step, tolerance)) show(r);
  show(bench::potential_row("circuit of the shape", *bench::shape_circuit(), step, tolerance));
  show(bench::potential_row("table", *bench::coarse_table(false), step, tolerance));
  show(bench::potential_row("table with ring", *bench::coarse_table(true), step, tolerance));
  for (const auto& r : bench::supply_rows(step, tolerance)) show(r);
  for (const double seconds : {100e-6, 50e-6}) show(bench::field_row(60, seconds, true));
  std::printf("residual: worst of the angles, every %.0f deg (solved every 60), of the energy supplied\n",
              step);
  for (int k = 1; k + 1 < argc; ++k)
    if (std::strcmp(argv[k], "--json") == 0)
      std::ofstream(argv[k + 1]) << Json{{"rows", list}}.dump(2) << '\n';
}
