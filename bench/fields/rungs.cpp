// What stands between the field and a closing, beside each other: two bilinear tables and one potential from the same
// field; a magnetic circuit below 1.5 mm blended into the field above it; the shaded pole in time and by phasors.
//   fields_rungs [--json PATH]

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fields/bilinear.h"
#include "bench/fields/blend.h"
#include "bench/fields/circuit.h"
#include "bench/fields/contactor.h"
#include "bench/fields/json_out.h"
#include "bench/fields/shaded_pole.h"
#include "core/cpu_time.h"
#include "core/random.h"
#include "core/units.h"
#include "sim/magnetics/plane/table_build.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

/// 230 V, 50 Hz at an angle onto the E-E contactor with 2000 turns.
sim::TransientSetup switch_on(double angle, double step) {
  sim::TransientSetup s;
  s.voltage = [angle](double t) { return 325.27 * std::sin(2 * pi * 50 * t + angle); };
  s.resistance = 250;
  s.mass = 0.12;
  s.counter_force = [](double gap) { return 10 - 1500 * gap; };
  s.start_gap = 3e-3;
  s.step = step;
  s.duration = 40e-3;
  return s;
}

/// Largest errors at random states, in percent: what a table makes of (i, gap), or the potential of (psi, gap).
struct Worst {
  double flux = 0, current = 0, pull = 0, gain = 0;
};

struct Truth {
  double current, gap, flux, pull;
};

std::vector<Truth> random_states(sim::MagnetField& field, double largest_current, double largest_gap) {
  std::vector<Truth> all;
  Random random(7);
  for (int k = 0; k < 400; ++k) {
    const double current = largest_current * random.uniform();
    const double gap = 0.3e-3 * std::expm1(random.uniform() * std::log1p(largest_gap / 0.3e-3));
    field.set_gap(gap);
    const auto p = field.at_current(current, 0);
    all.push_back({current, gap, field.fluxes(p).first, p.response.pull});
  }
  return all;
}

Json tables() {
  auto design = bench::reference_contactor();
  design.turns = 2000;
  design.residual_gap = 20e-6;
  constexpr double largest_current = 1.5, largest_gap = 6e-3, accuracy = 0.005;
  sim::TableOptions o;
  o.accuracy = accuracy;
  o.largest_gap = largest_gap;
  sim::FieldOptions field_options = sim::plan_table(design, o).field;
  field_options.newton.tolerance = 1e-10;
  sim::MagnetField field(design, field_options);
  const auto states = random_states(field, largest_current, largest_gap);
  constexpr double angle = 1.2, step = 50e-6;
  const auto in_loop = run_transient(design, field_options, switch_on(angle, step));
  std::printf(
      "E-E contactor, %d unknowns, 3000 A turns, 6 mm: two bilinear tables over (i, gap) and one potential "
      "over "
      "(psi, gap),\nboth from this field; worst of 400 random states (pull above 1 N); closing at %.0f deg, "
      "field in the loop %.4f ms\n",
      field.unknowns(), angle * 180 / pi, in_loop.closed_at * 1e3);
  std::printf("%6s %-10s %10s %10s %10s %14s %12s %10s %8s\n", "nodes", "", "psi %", "i %", "pull %",
              "loop gain %", "closing ms", "error us", "CPU s");
  Json list = Json::array();
  sim::Team team(1);
  for (const int n : {12, 24, 32})
    for (const bool bilinear : {true, false}) {
      const double start = process_cpu_seconds();
      std::unique_ptr<sim::MagneticPotential> p;
      o.psi_nodes = o.gap_nodes = n;
      if (bilinear)
        p = std::make_unique<bench::BilinearTables>(field, n, largest_current, largest_gap);
      else
        p = std::make_unique<sim::TablePotential>(build_table(design, o, team));
      const double cpu = process_cpu_seconds() - start;
      Worst w;
      for (const auto& t : states) {
        const auto r = p->at({t.flux, 0, t.gap});
        double pull = r.pull;
        if (const auto* two = dynamic_cast<const bench::BilinearTables*>(p.get())) {
          pull = two->pull(t.current, t.gap);
          w.flux = std::fmax(w.flux, std::fabs(two->flux(t.current, t.gap) / t.flux - 1));
        }
        w.current = std::fmax(w.current, std::fabs(r.current / t.current - 1));
        if (t.pull > 1) w.pull = std::fmax(w.pull, std::fabs(pull / t.pull - 1));
      }
      w.gain = bench::loop_gain(*p, 0.1, 0.6, 0, 3e-3, 20000);
      const auto closing = run_transient(*p, switch_on(angle, step));
      const double error = closing.closed_at - in_loop.closed_at;
      std::printf("%6d %-10s %10s %10.4f %10.4f %14.2e %12.4f %+10.2f %8.2f\n", n,
                  bilinear ? "bilinear" : "potential",
                  bilinear ? std::to_string(100 * w.flux).c_str() : "given", 100 * w.current, 100 * w.pull,
                  100 * w.gain, closing.closed_at * 1e3, error * 1e6, cpu);
      list.push_back({{"nodes", n},
                      {"bilinear", bilinear},
                      {"error_psi", bilinear ? Json(w.flux) : Json(nullptr)},
                      {"error_current", w.current},
                      {"error_pull", w.pull},
                      {"loop_gain", w.gain},
                      {"closing_s", closing.closed_at},
                      {"closing_error_s", error},
                      {"cpu_s", cpu}});
    }
  return list;
}

/// One rung below a gap, another above it, without a blend: what the blend is there to avoid.
class Switched final : public sim::MagneticPotential {
 public:
  Switched(std::shared_ptr<const sim::MagneticPotential> below,
           std::shared_ptr<const sim::MagneticPotential> above, double gap)
      : below_(std::move(below)), above_(std::move(above)), gap_(gap) {}
  bool has_ring() const override { return below_->has_ring(); }
  sim::MagneticResponse at(const sim::MagneticState& s) const override {
    return s.gap < gap_ ? below_->at(s) : above_->at(s);
  }

 private:
  std::shared_ptr<const sim::MagneticPotential> below_, above_;
  double gap_;
};

Json mixed() {
  sim::MagnetDesign design;
  design.steel = sim::builtin_steel("lamination");
  sim::TableOptions o;
  o.accuracy = 0.01;
  o.psi_nodes = o.gap_nodes = 20;
  o.ring_nodes = 12;
  sim::Team team(1);
  const auto table = std::make_shared<sim::TablePotential>(build_table(design, o, team));
  const auto circuit =
      std::make_shared<sim::CircuitPotential>(design.shape, design.steel, design.turns, design.residual_gap,
                                              design.end_leakage, sim::CircuitOptions{false});
  const auto blend = std::make_shared<bench::BlendedPotential>(circuit, table, 1e-3, 2e-3);
  const Switched hard(circuit, table, 1.5e-3);
  constexpr double psi = 0.5, ring = 5e-5;
  const auto at = [&](const sim::MagneticPotential& p, double gap) { return p.at({psi, ring, gap}); };
  const auto low = at(hard, 1.5e-3 - 1e-9), high = at(hard, 1.5e-3);
  std::printf(
      "\nReference magnet with ring: the field's table at all gaps, and above 1.5 mm only with the circuit "
      "below (a switch, or blended from 1 to 2 mm)\n"
      "at 1.5 mm, %.1f Wb, ring %.0f uWb the switch jumps in pull by %+.2f %%, in energy by %+.3f %%; "
      "closing "
      "ms and energy residual\n",
      psi, ring * 1e6, 100 * (high.pull / low.pull - 1), 100 * (high.energy / low.energy - 1));
  std::printf("%6s %12s %12s %12s %12s %12s %10s %10s %10s\n", "deg", "table", "blend", "switch", "circuit",
              "blend-table", "res table", "res blend", "res switch");
  Json list = Json::array();
  for (int degrees = 0; degrees < 180; degrees += 30) {
    auto s = switch_on(radians(degrees), 10e-6);
    s.ring_resistance = 0.6e-3;
    s.start_gap = 5e-3;
    s.duration = 60e-3;
    const auto t = run_transient(*table, s), b = run_transient(*blend, s), h = run_transient(hard, s),
               c = run_transient(*circuit, s);
    std::printf("%6d %12.4f %12.4f %12.4f %12.4f %+12.4f %10.1e %10.1e %10.1e\n", degrees, t.closed_at * 1e3,
                b.closed_at * 1e3, h.closed_at * 1e3, c.closed_at * 1e3, (b.closed_at - t.closed_at) * 1e3,
                t.energy.residual(), b.energy.residual(), h.energy.residual());
    list.push_back({{"angle_deg", degrees},
                    {"table_s", t.closed_at},
                    {"blend_s", b.closed_at},
                    {"switch_s", h.closed_at},
                    {"circuit_s", c.closed_at},
                    {"residual_table", t.energy.residual()},
                    {"residual_blend", b.energy.residual()},
                    {"residual_switch", h.energy.residual()}});
  }
  return {{"jump_pull", high.pull / low.pull - 1},
          {"jump_energy", high.energy / low.energy - 1},
          {"closings", list}};
}

Json shaded() {
  const bench::ShadedCase c;
  const double resistance = bench::ring_resistance(c);
  const auto truth = bench::by_phasors(c);
  std::printf(
      "\nShaded pole, closed, mu_r 2000, 230 V 50 Hz, rings of copper %.4f mohm: phasors with a massive "
      "ring: "
      "lag %.3f deg, pull least %.3f N, mean %.3f N\n%-34s %9s %9s %11s %9s %11s %9s %8s\n",
      resistance * 1e3, truth.lag, truth.least_pull, truth.mean_pull, "", "lag deg", "error %", "least N",
      "error %", "mean N", "error %", "CPU s");
  Json list = Json::array();
  const auto row = [&](const char* name, double step, const auto& run) {
    const auto s = bench::shaded_setup(c, step, 10);
    const double start = process_cpu_seconds();
    const auto r = bench::by_time(c.hertz, c.design.turns, s, run(s));
    const double cpu = process_cpu_seconds() - start;
    const auto error = [](double a, double b) { return 100 * (a / b - 1); };
    std::printf("%-34s %9.3f %+9.3f %11.3f %+9.3f %11.3f %+9.3f %8.3f\n", name, r.lag,
                error(r.lag, truth.lag), r.least_pull, error(r.least_pull, truth.least_pull), r.mean_pull,
                error(r.mean_pull, truth.mean_pull), cpu);
    list.push_back({{"rung", name},
                    {"lag_deg", r.lag},
                    {"least_pull_N", r.least_pull},
                    {"mean_pull_N", r.mean_pull},
                    {"error_lag", r.lag / truth.lag - 1},
                    {"error_least_pull", r.least_pull / truth.least_pull - 1},
                    {"error_mean_pull", r.mean_pull / truth.mean_pull - 1},
                    {"cpu_s", cpu}});
  };
  row("field in the loop, ring one turn", 100e-6,
      [&](const sim::TransientSetup& s) { return run_transient(c.design, c.options, s); });
  sim::TableOptions o;
  o.accuracy = 0.005;
  o.psi_nodes = o.gap_nodes = o.ring_nodes = 12;
  o.largest_gap = 1e-3;
  sim::Team team(1);
  const sim::TablePotential table(build_table(c.design, o, team));
  row("table", 20e-6, [&](const sim::TransientSetup& s) { return run_transient(table, s); });
  const sim::CircuitPotential circuit(c.design.shape, c.design.steel, c.design.turns, c.design.residual_gap,
                                      0, {false});
  row("circuit", 20e-6, [&](const sim::TransientSetup& s) { return run_transient(circuit, s); });
  return {{"lag_deg", truth.lag},
          {"least_pull_N", truth.least_pull},
          {"mean_pull_N", truth.mean_pull},
          {"ring_resistance_ohm", resistance},
          {"rows", list}};
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  const Json result{
      {"benchmark", "fields_rungs"}, {"tables", tables()}, {"mixed", mixed()}, {"shaded_pole", shaded()}};
  return bench::write_json(argc, argv, result);
}
