// Solenoids: the published one of the Modelica Standard Library, static and at its pull-in; faces that are not flat
// beside FreeFem++ on its own mesh; what eddy currents in solid iron add.
//   fields_solenoid [--json PATH]

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/fields/json_out.h"
#include "bench/fields/published_solenoid.h"
#include "bench/fields/solenoid_peer.h"
#include "sim/models/solenoid/solenoid_closing.h"
#include "sim/models/solenoid/solenoid_eddy_closing.h"
#include "sim/models/solenoid/solenoid_live.h"

namespace {

using namespace powbench;
using Json = nlohmann::ordered_json;

constexpr double none = std::numeric_limits<double>::quiet_NaN(), volts = 12;

sim::FieldOptions options(double accuracy) {
  sim::FieldOptions o;
  o.sizes = sim::sizes_for(accuracy);
  return o;
}

sim::SolenoidSpecimen specimen() {
  sim::SolenoidSpecimen s;
  s.design = bench::published_solenoid();
  s.coil.resistance = 10;
  s.plunger.mass = 7853 * 26e-3 * pi * 25e-6;
  s.plunger.load_mass = 0.01;
  s.plunger.return_preload = s.plunger.return_rate = 0;
  return s;
}

Json statics() {
  const auto design = bench::published_solenoid();
  sim::SolenoidField field(design, options(1e-3));
  std::printf("Published solenoid, 1.2 A: own grid of %d unknowns beside the published finite elements\n",
              field.unknowns());
  std::printf("%7s %10s %10s %8s %11s %11s %8s\n", "gap mm", "pull N", "published", "%", "L H", "published",
              "%");
  Json list = Json::array();
  double pull_sum = 0, pull_worst = 0, l_worst = 0;
  for (const auto& row : bench::published_statics) {
    field.set_gap(std::max(row.gap - design.residual_gap, 0.0));
    const auto p = field.at_current(1.2);
    const double pull = p.response.pull / row.pull - 1, l = field.flux(p) / 1.2 / row.inductance - 1;
    std::printf("%7.2f %10.4f %10.4f %+8.2f %11.6f %11.6f %+8.2f\n", row.gap * 1e3, p.response.pull, row.pull,
                100 * pull, field.flux(p) / 1.2, row.inductance, 100 * l);
    pull_sum += pull;
    pull_worst = std::fmax(pull_worst, std::fabs(pull));
    l_worst = std::fmax(l_worst, std::fabs(l));
    list.push_back({{"gap_m", row.gap},
                    {"pull_N", p.response.pull},
                    {"pull_to_published", pull},
                    {"inductance_to_published", l}});
  }
  // where the iron is linear the pull is i^2 / 2 dL/dgap: what the published numbers say about themselves
  const auto& rows = bench::published_statics;
  double slope_sum = 0;
  int slopes = 0;
  for (std::size_t k = 11; k + 1 < rows.size(); ++k, ++slopes)
    slope_sum += 0.5 * 1.2 * 1.2 * (rows[k - 1].inductance - rows[k + 1].inductance) /
                     (rows[k + 1].gap - rows[k - 1].gap) / rows[k].pull -
                 1;
  std::printf(
      "from 3 mm on i^2 / 2 dL/dgap of the published inductance is %+.2f %% of the published pull in the "
      "mean\n",
      100 * slope_sum / slopes);
  std::printf("pull: %+.2f %% in the mean, %.2f %% at most; inductance: %.2f %% at most\n",
              100 * pull_sum / static_cast<double>(bench::published_statics.size()), 100 * pull_worst,
              100 * l_worst);
  return list;
}

Json pull_in() {
  auto s = specimen();
  sim::TableOptions t;
  sim::Team team(1);
  const sim::TablePotential table(build_table(s.design, t, team));
  sim::SolenoidCase c;
  c.supply.mains.kind = sim::Mains::Kind::dc;
  c.supply.mains.volts = volts;
  c.duration = 15e-3;
  c.sample_step = 100e-6 / 3;
  std::printf(
      "\nPull-in at 12 V, 10 ohm, 26.04 g, no spring: published %.4f ms, peak of the current %.4f A\n%-44s "
      "%9s %8s %9s %8s %9s\n",
      bench::published_pull_in_time * 1e3, bench::published_peak_current, "", "ms", "%", "peak A", "%",
      "residual");
  Json list = Json::array();
  const auto add = [&](const std::string& name, const sim::SolenoidRun& run) {
    const double time = run.truth.seat.value_or(none), error = time / bench::published_pull_in_time - 1,
                 peak = run.truth.peak_current / bench::published_peak_current - 1;
    std::printf("%-44s %9.4f %+8.2f %9.4f %+8.2f %9.1e\n", name.c_str(), time * 1e3, 100 * error,
                run.truth.peak_current, 100 * peak, run.energy_residual);
    list.push_back(
        {{"fields", name}, {"pull_in_s", time}, {"to_published", error}, {"peak_to_published", peak}});
    return run;
  };
  const auto run = add("table, 0.5 %", sim::simulate_solenoid(s, table, c));
  {
    auto live = c;
    live.tolerance = 1e-6;
    add("field in the loop, 0.5 %",
        sim::simulate_solenoid(s, sim::LiveSolenoid(s.design, options(5e-3)), live));
    add("field in the loop, 0.2 %",
        sim::simulate_solenoid(s, sim::LiveSolenoid(s.design, options(2e-3)), live));
  }
  for (const double conductivity : {1e-3, 1e6, 5e6}) {
    s.conductivity = conductivity;
    char name[80];
    std::snprintf(name, sizeof name, "eddy currents, 0.5 %%, %g MS/m", conductivity * 1e-6);
    add(name, sim::simulate_solenoid_eddies(s, options(5e-3), c));
  }
  std::printf("\nBy the table, over time\n%7s %9s %9s %7s %9s %9s %7s %9s %9s %8s\n", "ms", "A", "published",
              "%", "N", "published", "%", "gap mm", "published", "um");
  for (const auto& row : bench::published_pull_in) {
    const sim::SolenoidSample* at = &run.samples.front();
    for (const auto& q : run.samples)
      if (std::fabs(q.time - row.time) < std::fabs(at->time - row.time)) at = &q;
    const double gap = s.travel() - at->travel + s.design.residual_gap;
    std::printf("%7.3f %9.5f %9.5f %+7.2f %9.4f %9.4f %+7.2f %9.5f %9.5f %+8.1f\n", row.time * 1e3,
                at->current, row.current, 100 * (at->current / row.current - 1), at->pull, row.pull,
                100 * (at->pull / row.pull - 1), gap * 1e3, row.gap * 1e3, (gap - row.gap) * 1e6);
  }
  return list;
}

Json faces() {
  const std::string folder = (std::filesystem::temp_directory_path() / "powbench_fields_solenoid").string();
  std::printf(
      "\nFaces that are not flat, 1000 turns: beside FreeFem++ on its own mesh, steel reference\n%-10s %7s "
      "%5s %12s %10s "
      "%9s %9s %9s %9s %9s\n",
      "face", "gap mm", "A", "flux Wb", "pull N", "psi peer%", "F peer %", "-dW/dx %", "unknowns",
      "peer dofs");
  Json list = Json::array();
  for (const auto face : {sim::PlungerFace::conical, sim::PlungerFace::stepped}) {
    sim::SolenoidDesign d;
    d.shape.face = face;
    const bool cone = face == sim::PlungerFace::conical;
    if (cone) {
      d.shape.cone_angle = pi / 4;
      d.shape.tip_radius = 2e-3;
    } else {
      d.shape.step_radius = 4e-3;
      d.shape.step_depth = 3e-3;
      d.shape.step_clearance = 0.5e-3;
    }
    sim::SolenoidField field(d, options(2e-3));
    for (const double gap : {0.5e-3, 3e-3, 8e-3})
      for (const double current : {1.0}) {
        field.set_gap(gap);
        const auto p = field.at_current(current);
        const double psi = field.flux(p), step = 0.01 * gap;
        field.set_gap(gap + step);
        const double high = field.at_flux(psi, p.a).response.energy;
        field.set_gap(gap - step);
        const double slope =
            (high - field.at_flux(psi, p.a).response.energy) / (2 * step) / p.response.pull - 1;
        const auto peer = bench::solenoid_by_freefem(folder, d, gap + d.residual_gap, current, 1);
        const double p_psi = peer ? psi / peer->flux - 1 : none,
                     p_pull = peer ? p.response.pull / peer->pull - 1 : none;
        const char* name = cone ? "conical" : "stepped";
        std::printf("%-10s %7.2f %5.1f %12.8f %10.4f %+9.3f %+9.3f %+9.3f %9d %9d\n", name, gap * 1e3,
                    current, psi, p.response.pull, 100 * p_psi, 100 * p_pull, 100 * slope, field.unknowns(),
                    peer ? peer->unknowns : 0);
        list.push_back({{"face", name},
                        {"gap_m", gap},
                        {"current_A", current},
                        {"flux_Wb", psi},
                        {"pull_N", p.response.pull},
                        {"psi_to_peer", p_psi},
                        {"pull_to_peer", p_pull},
                        {"energy_slope", slope}});
      }
  }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  setvbuf(stdout, nullptr, _IOLBF, 0);
  const Json result{
      {"benchmark", "fields_solenoid"}, {"statics", statics()}, {"pull_in", pull_in()}, {"faces", faces()}};
  return bench::write_json(argc, argv, result);
}
