#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/plane/solenoid_field.h"

/// The solenoid of the Modelica Standard Library 4.1, Magnetic.FluxTubes.Examples.SolenoidActuator: its parameters,
/// and what its two comparison models hold as results of finite elements (ComparisonQuasiStatic,
/// ComparisonPullInStroke; Modelica Association, BSD 3-clause). The pull-in there is by look-up tables of static
/// finite elements. 12 V and 10 ohm, no spring, 26.04 g.

namespace powbench::bench {

struct PublishedStatic {
  double gap, pull, inductance;  ///< m, N, H at 1.2 A
};
inline constexpr std::array<PublishedStatic, 20> published_statics{{
    {0.25e-3, 85.8619, 0.11954},  {0.5e-3, 59.9662, 0.11004},  {0.75e-3, 41.0806, 0.098942},
    {1e-3, 28.88, 0.088425},      {1.25e-3, 21.4113, 0.08015}, {1.5e-3, 16.8003, 0.073992},
    {1.75e-3, 13.6942, 0.068792}, {2e-3, 11.1188, 0.064492},   {2.25e-3, 9.6603, 0.060917},
    {2.5e-3, 8.4835, 0.058017},   {2.75e-3, 7.4658, 0.055125}, {3e-3, 6.5591, 0.052733},
    {3.25e-3, 5.9706, 0.05035},   {3.5e-3, 5.5013, 0.048525},  {3.75e-3, 5.0469, 0.046867},
    {4e-3, 4.6573, 0.045158},     {4.25e-3, 4.2977, 0.043442}, {4.5e-3, 4.0912, 0.04205},
    {4.75e-3, 3.7456, 0.040733},  {5e-3, 3.5869, 0.039467},
}};

struct PublishedInstant {
  double time, current, pull, gap;  ///< s, A, N, m
};
inline constexpr std::array<PublishedInstant, 13> published_pull_in{{
    {1e-3, 0.26842, 0.185107, 0.00499928},
    {2e-3, 0.47634, 0.571317, 0.00499085},
    {3e-3, 0.63586, 1.02121, 0.00496027},
    {4e-3, 0.755536, 1.45743, 0.00489052},
    {5e-3, 0.841631, 1.84622, 0.00476495},
    {6e-3, 0.899322, 2.24774, 0.00456827},
    {7e-3, 0.93205, 2.58498, 0.00428527},
    {8e-3, 0.937133, 2.94589, 0.0039026},
    {9e-3, 0.926467, 3.40014, 0.00340636},
    {10e-3, 0.883343, 4.01357, 0.00277938},
    {11e-3, 0.802204, 5.04175, 0.00199695},
    {12e-3, 0.62734, 8.29718, 0.00101097},
    {12.6134e-3, 0.371242, 16.2777, 0.00025},
}};
inline constexpr double published_pull_in_time = 12.6134e-3;  ///< s, first arrival at the stop
inline constexpr double published_peak_current = 0.937532;    ///< A, at 7.6 ms

/// The library's steel 9SMnPb28, mu_r(B) = 1 + (mu_i - 1 + c_a x) / (1 + c_b x + x^n), x = B / B_max.
inline sim::Steel published_steel() {
  constexpr double first = 400, peak = 1.488, a = 1200, b = 3, n = 12.5, step = 0.05, last = 2.2;
  std::vector<sim::BhRow> rows;
  for (double t = step; t < last + 0.5 * step; t += step) {
    const double x = t / peak, mu = 1 + (first - 1 + a * x) / (1 + b * x + std::pow(x, n));
    rows.push_back({t, t / (sim::mu0 * mu)});
  }
  return sim::Steel::table("9SMnPb28", std::move(rows));
}

/// As in scenes/solenoid.specimen.toml: the winding fills its window.
inline sim::SolenoidDesign published_solenoid() {
  sim::SolenoidDesign d;
  auto& s = d.shape;
  s.plunger_radius = 5e-3;
  s.bore_radius = 5.65e-3;
  s.plunger_length = 26e-3;
  s.stop_length = 6.5e-3;
  s.window = 28e-3;
  s.plate = s.flange = 3.5e-3;
  s.coil_inner = 5.75e-3;
  s.coil_outer = 13.4e-3;
  s.coil_clearance = 0.1e-3;
  s.case_inner = 13.5e-3;
  s.case_outer = 15e-3;
  d.steel = published_steel();
  d.turns = 957;
  d.residual_gap = 0.25e-3;
  d.largest_gap = 4.75e-3;
  return d;
}

}  // namespace powbench::bench
