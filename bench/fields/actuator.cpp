// A solenoid whose plunger slides through a flange: static pull beside FreeFem++ on its own mesh and beside a finer own
// grid, and the pull-in from the table W(psi, gap) beside the closing with the field in the loop.
//   fields_actuator [--json PATH]

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fields/json_out.h"
#include "bench/fields/solenoid_peer.h"
#include "core/cpu_time.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

constexpr double table_accuracy = 0.005;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

sim::FieldOptions options(double accuracy) {
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(accuracy);
  return o;
}

Json statics() {
  const sim::SolenoidDesign design;
  const std::string folder = (std::filesystem::temp_directory_path() / "powbench_fields_actuator").string();
  sim::SolenoidField field(design, options(0.4 * table_accuracy)), fine(design, options(2.5e-4));
  std::printf(
      "Solenoid, %g turns, residual gap %g mm: own grid %d unknowns, beside %d unknowns and beside FreeFem++ "
      "(own mesh)\n",
      design.turns, design.residual_gap * 1e3, field.unknowns(), fine.unknowns());
  std::printf("%7s %5s %12s %10s %9s %9s %9s %9s %9s %9s %5s %9s\n", "gap mm", "A", "flux Wb", "pull N",
              "psi fine%", "F fine %", "psi peer%", "F peer %", "thin %", "-dW/dx %", "its", "peer dofs");
  Json list = Json::array();
  for (const double gap : {0.0, 0.5e-3, 2e-3, 5e-3, 10e-3})
    for (const double current : {0.5, 1.0, 2.0}) {
      field.set_gap(gap);
      const auto p = field.at_current(current);
      const double psi = field.flux(p);
      fine.set_gap(gap);
      const auto q = fine.at_current(current);
      const double f_psi = psi / fine.flux(q) - 1, f_pull = p.response.pull / q.response.pull - 1;
      // the slope of the energy over the grids of two gaps, where both lie within the reach
      double slope = none;
      if (gap > 0 && gap < design.largest_gap) {
        const double step = 0.01 * gap;
        field.set_gap(gap + step);
        const double high = field.at_flux(psi, p.a).response.energy;
        field.set_gap(gap - step);
        slope = (high - field.at_flux(psi, p.a).response.energy) / (2 * step) / p.response.pull - 1;
      }
      const auto peer = bench::solenoid_by_freefem(folder, design, gap + design.residual_gap, current, 1);
      const double p_psi = peer ? psi / peer->flux - 1 : none,
                   p_pull = peer ? p.response.pull / peer->pull - 1 : none;
      const double thin = p.stress_pull / p.response.pull - 1;
      std::printf("%7.2f %5.1f %12.8f %10.4f %+9.3f %+9.3f %+9.3f %+9.3f %+9.3f %+9.3f %5d %9d\n", gap * 1e3,
                  current, psi, p.response.pull, 100 * f_psi, 100 * f_pull, 100 * p_psi, 100 * p_pull,
                  100 * thin, 100 * slope, p.newton.iterations, peer ? peer->unknowns : 0);
      list.push_back({{"gap_m", gap},
                      {"current_A", current},
                      {"flux_Wb", psi},
                      {"pull_N", p.response.pull},
                      {"psi_to_fine", f_psi},
                      {"pull_to_fine", f_pull},
                      {"psi_to_peer", p_psi},
                      {"pull_to_peer", p_pull},
                      {"pull_thin_layer", thin},
                      {"energy_slope", slope},
                      {"iterations", p.newton.iterations}});
    }
  return list;
}

/// 24 V from rest against a spring.
sim::TransientSetup pull_in(double step) {
  sim::TransientSetup s;
  s.voltage = [](double) { return 24.0; };
  s.resistance = 9;
  s.mass = 0.07;
  s.counter_force = [](double gap) { return 5 + 300 * (10e-3 - gap); };
  s.start_gap = 10e-3;
  s.step = step;
  s.duration = 40e-3;
  return s;
}

Json dynamics() {
  const sim::SolenoidDesign design;
  sim::Team team(1);
  sim::TableOptions o;
  o.accuracy = table_accuracy;
  o.psi_nodes = o.gap_nodes = 24;
  sim::TableReport report;
  double start = process_cpu_seconds();
  const sim::TablePotential table(build_table(design, o, team, &report));
  const double building = process_cpu_seconds() - start;
  std::printf(
      "\nPull-in at 24 V, 9 ohm, 70 g, 10 mm: table 24 x 24 (%d unknowns, %.2f s CPU, least d2W/dpsi2 %.3g) "
      "beside the field in the loop\n%-32s %9s %12s %9s %12s %12s %10s\n",
      report.unknowns, building, table.least_stiffness(), "", "step us", "pull-in ms", "to best %",
      "speed m/s", "residual", "CPU s");
  struct Line {
    std::string name;
    double step;
    sim::TransientResult result;
    double cpu;
  };
  std::vector<Line> lines;
  const auto add = [&](const std::string& name, double step, const auto& run) {
    start = process_cpu_seconds();
    auto result = run(pull_in(step));
    lines.push_back({name, step, std::move(result), process_cpu_seconds() - start});
  };
  const auto in_loop = [&](double accuracy) {
    return [&design, accuracy](const sim::TransientSetup& s) {
      return run_transient(design, options(accuracy), s);
    };
  };
  add("field in the loop, 0.05 %", 50e-6, in_loop(5e-4));
  add("field in the loop, 0.2 %", 50e-6, in_loop(0.4 * table_accuracy));
  add("field in the loop, 0.2 %", 100e-6, in_loop(0.4 * table_accuracy));
  add("field in the loop, 2 %", 100e-6, in_loop(0.02));
  const auto by_table = [&](const sim::TransientSetup& s) { return run_transient(table, s); };
  add("table", 50e-6, by_table);
  add("table", 10e-6, by_table);
  Json list = Json::array();
  for (const auto& l : lines) {
    double speed = 0;
    for (const auto& s : l.result.samples) speed = std::fmax(speed, std::fabs(s.velocity));
    const double error = l.result.closed_at / lines.front().result.closed_at - 1,
                 residual = l.result.energy.residual();
    std::printf("%-32s %9.0f %12.4f %+9.3f %12.4f %+12.2e %10.4f\n", l.name.c_str(), l.step * 1e6,
                l.result.closed_at * 1e3, 100 * error, speed, residual, l.cpu);
    list.push_back({{"rung", l.name},
                    {"step_s", l.step},
                    {"pull_in_s", l.result.closed_at},
                    {"to_best", error},
                    {"largest_speed_m_per_s", speed},
                    {"energy_residual", residual},
                    {"cpu_s", l.cpu}});
  }
  return {{"table_cpu_s", building}, {"rows", list}};
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  const Json result{{"benchmark", "fields_actuator"}, {"statics", statics()}, {"pull_in", dynamics()}};
  return bench::write_json(argc, argv, result);
}
