// Rows of docs/validation/field-hard-cases.md that print their figure: sheets, rings, noise, edges.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdio>

#include "bench/fields/circuit.h"
#include "bench/fields/contactor.h"
#include "core/units.h"
#include "sim/magnetics/plane/field_transient.h"
#include "sim/magnetics/plane/table_build.h"

using namespace powbench::sim;
using powbench::pi;
using Complex = std::complex<double>;

namespace {

/// Iron alone, linear: i = psi / L.
class Choke final : public MagneticPotential {
 public:
  explicit Choke(double inductance) : inductance_(inductance) {}
  bool has_ring() const override { return false; }
  MagneticResponse at(const MagneticState& s) const override {
    MagneticResponse r;
    r.current = s.psi / inductance_;
    r.energy = 0.5 * s.psi * r.current;
    r.current_psi = 1 / inductance_;
    return r;
  }

 private:
  double inductance_;
};

/// Phasor of a signal in the last period of a run that ends with a whole one: a cosine has phase 0.
template <class Get>
Complex phasor(const TransientResult& r, double step, double hertz, const Get& get) {
  const auto period = static_cast<std::size_t>(std::lround(1 / (hertz * step)));
  Complex sum = 0;
  for (std::size_t k = r.samples.size() - period; k < r.samples.size(); ++k) {
    // a sample's current is that of the middle of its step, its flux that of the end
    const auto [time, value] = get(r.samples[k]);
    sum += value * std::exp(Complex(0, -2 * pi * hertz * time));
  }
  return 2.0 * sum / static_cast<double>(period);
}

}  // namespace

TEST_CASE("eddy currents in sheets: one resistance beside the flux against the law of a sheet, to 1 kHz") {
  // sheets of 0.5 mm, relative permeability 2000, 2 MS/m; a ring-shaped core of 0.1 m and 1 cm2 with 100 turns
  constexpr double d = 0.5e-3, mu = 2000 * 4e-7 * pi, sigma = 2e6, length = 0.1, area = 1e-4, turns = 100;
  const Choke choke(turns * turns * mu * area / length);
  const double parallel = 12 * turns * turns * area / (sigma * d * d * length);
  for (const double hertz : {50.0, 200.0, 1000.0}) {
    const double omega = 2 * pi * hertz;
    const Complex z = Complex(1, 1) * d / (2 * std::sqrt(2 / (omega * mu * sigma)));
    const Complex exact = z / std::tanh(z);  // of the current over that without eddy currents
    const auto ratio = [&](double resistance) {
      TransientSetup s;
      s.voltage = [omega](double t) { return std::cos(omega * t); };
      s.resistance = 0;
      s.sheet_resistance = resistance;
      s.moves = false;
      s.step = 1 / (hertz * 2000);
      s.duration = 2 / hertz;
      const auto r = run_transient(choke, s);
      CHECK(std::fabs(r.energy.supplied - r.energy.eddy_loss - r.energy.stored) < 1e-9);
      const Complex current = phasor(r, s.step, hertz, [&](const TransientSample& p) {
        return std::pair{p.time - 0.5 * s.step, p.current};
      });
      const Complex flux = phasor(r, s.step, hertz, [](const TransientSample& p) {
        return std::pair{p.time, p.psi};
      });
      return current / (flux / (turns * turns * mu * area / length));
    };
    const auto off = [&](const Complex& r) { return std::abs(r / exact - 1.0); };
    const double with = off(ratio(parallel)), without = off(ratio(0));
    std::printf("sheets, %g Hz: current %.2f %% off the law of a sheet with R_e, %.1f %% without\n", hertz,
                100 * with, 100 * without);
    // z coth z = 1 + z^2 / 3 - z^4 / 45 + ..: R_e is the second term, the error the third
    const double third = std::pow(std::abs(z), 4) / 45;
    CHECK(with < 1.1 * third);
    CHECK(without > 2 * third);
  }
}

TEST_CASE("eddy currents in sheets: the field in the loop and its table lose the same energy") {
  auto design = powbench::bench::reference_contactor();
  design.turns = 1000;
  design.residual_gap = 20e-6;
  TableOptions o;
  o.accuracy = 0.05;
  o.psi_nodes = 16;
  o.gap_nodes = 10;
  o.largest_gap = 3e-3;
  const CircuitPotential circuit(design.shape, design.steel, design.turns, design.residual_gap);
  TransientSetup s;
  s.sheet_resistance = circuit.sheet_resistance(0.5e-3, 2e6);
  s.voltage = [](double t) { return 150 * std::cos(314.159265358979 * t); };
  s.resistance = 20;
  s.start_gap = 2e-3;
  s.step = 40e-6;
  s.duration = 12e-3;
  Team team(2);
  const auto by_table = run_transient(TablePotential(build_table(design, o, team)), s);
  const auto by_field = run_transient(design, plan_table(design, o).field, s);
  s.sheet_resistance = 0;
  const auto without = run_transient(design, plan_table(design, o).field, s);
  std::printf("sheets, R_e = %.3g kohm: loss %.3f mJ by table, %.3f mJ by field; residuals %.0e, %.0e\n",
              circuit.sheet_resistance(0.5e-3, 2e6) * 1e-3, by_table.energy.eddy_loss * 1e3,
              by_field.energy.eddy_loss * 1e3, by_table.energy.residual(), by_field.energy.residual());
  CHECK(by_table.energy.eddy_loss > 0);
  CHECK(without.energy.eddy_loss == 0);
  CHECK(by_table.energy.eddy_loss == Approx(by_field.energy.eddy_loss).epsilon(5e-3));
  CHECK(std::fabs(by_table.energy.residual()) < 1e-3);
  CHECK(std::fabs(by_field.energy.residual()) < 1e-3);
  CHECK_THROWS_WITH(circuit.sheet_resistance(0.5, 2e6), Catch::Contains("thickness of a sheet = 500"));
}

TEST_CASE("a ring of zero resistance keeps its flux, one of infinite resistance is not there") {
  MagnetDesign design;
  MagnetDesign bare = design;
  FieldOptions o;
  o.sizes = sizes_for(0.02);
  TransientSetup s;
  s.voltage = [](double t) { return 325 * std::cos(314.159265358979 * t); };
  s.resistance = 245;
  s.moves = false;
  s.start_gap = 0.2e-3;
  s.step = 100e-6;
  s.duration = 10e-3;
  const auto largest = [](const TransientResult& r, auto get) {
    double most = 0;
    for (const auto& p : r.samples) most = std::max(most, std::fabs(get(p)));
    return most;
  };
  const auto ring_current = [](const TransientSample& p) { return p.ring_current; };
  const auto run = [&](double ohm) {
    s.ring_resistance = ohm;
    return run_transient(design, o, s);
  };
  const auto none = run(1e-12), usual = run(1.18e-3), open = run(1e9);
  // without resistance a flux through the ring never starts: the loss is R times the largest current's square
  CHECK(none.energy.ring_loss < 1e-9 * usual.energy.ring_loss + 1e-12 * 1e4 * s.duration * 1e3);
  CHECK(largest(open, ring_current) < 1e-6 * largest(usual, ring_current));
  CHECK(open.energy.ring_loss < 1e-5 * usual.energy.ring_loss);
  MagnetField field(design, o);
  field.set_gap(s.start_gap);
  double worst_open = 0, worst_flux = 0;
  for (const auto* r : {&open, &none}) {
    double psi = 0;
    for (std::size_t k = 4; k < r->samples.size(); k += 12) {
      // a sample's current is that of the middle of its step
      psi = 0.5 * (r->samples[k].psi + r->samples[k - 1].psi);
      const auto p = field.at_flux(psi, 0, {}, r == &open);
      worst_open = std::max(worst_open, std::fabs(p.response.current / r->samples[k].current - 1));
      if (r == &none)
        worst_flux =
            std::max(worst_flux, std::fabs(p.response.ring_current / r->samples[k].ring_current - 1));
    }
  }
  std::printf("ring of 1e-12 and 1e9 ohm: current %.1e off the field with closed and with open ring\n",
              worst_open);
  CHECK(worst_open < 1e-5);
  CHECK(worst_flux < 1e-5);
}

TEST_CASE("the pull over 60 gaps has no noise: what a smooth curve misses is round-off of its own bend") {
  auto design = powbench::bench::reference_contactor();
  FieldOptions o;
  o.sizes = sizes_for(0.01);
  o.newton.tolerance = 1e-14;
  MagnetField field(design, o);
  std::vector<double> pull, slope;
  constexpr double step = 2e-6;
  for (int k = 0; k < 60; ++k) {
    field.set_gap(1e-3 + k * step);
    const auto p = field.at_current(1000, 0);
    pull.push_back(p.response.pull);
  }
  // sixth differences: a smooth curve's are of the order of step^6
  double noise = 0;
  for (std::size_t k = 3; k + 3 < pull.size(); ++k) {
    const double d = pull[k - 3] - 6 * pull[k - 2] + 15 * pull[k - 1] - 20 * pull[k] + 15 * pull[k + 1] -
                     6 * pull[k + 2] + pull[k + 3];
    noise = std::max(noise, std::fabs(d) / std::sqrt(924.0));
  }
  std::printf("pull over 60 gaps of 2 um: noise %.1e of the pull\n", noise / pull.front());
  CHECK(noise < 1e-8 * pull.front());
}

TEST_CASE("Newton from zero: the search along the step saves what full steps lose") {
  auto design = powbench::bench::reference_contactor();
  design.steel = builtin_steel("team13");
  int lost = 0, most = 0, failed = 0;
  for (const bool search : {false, true}) {
    FieldOptions o;
    o.sizes = sizes_for(0.01);
    o.newton.line_search = search;
    o.newton.most_iterations = 40;
    MagnetField field(design, o);
    for (const double gap : {0.02e-3, 0.1e-3, 0.5e-3, 2e-3, 5e-3})
      for (const double current : {30.0, 300.0, 1000.0, 3000.0, 10000.0}) {
        field.set_gap(gap);
        const auto p = field.at_current(current, 0);
        (search ? failed : lost) += !p.newton.converged;
        if (search) most = std::max(most, p.newton.iterations);
      }
  }
  std::printf("25 cold starts: full steps fail in %d, with the search %d, at most %d iterations\n", lost,
              failed, most);
  CHECK(lost > 0);
  CHECK(failed == 0);
  CHECK(most <= 25);
}

TEST_CASE("the ring's current goes through the core's impact without a jump") {
  MagnetDesign design;
  FieldOptions o;
  o.sizes = sizes_for(0.02);
  TransientSetup s;
  s.voltage = [](double t) { return 325 * std::cos(314.159265358979 * t); };
  s.resistance = 245;
  s.ring_resistance = 1.18e-3;
  s.mass = 0.02;
  s.start_gap = 0.5e-3;
  s.counter_force = [](double) { return 2.0; };
  s.duration = 2e-3;
  // what changes in the steps around the impact, over the peak so far
  const auto change = [&](double step) {
    s.step = step;
    const auto r = run_transient(design, o, s);
    REQUIRE(r.closed_at > 0);
    double at_impact = 0, largest = 0;
    for (std::size_t k = 1; k < r.samples.size(); ++k) {
      const double jump = std::fabs(r.samples[k].ring_current - r.samples[k - 1].ring_current);
      if (std::fabs(r.samples[k].time - r.closed_at) < 3 * step) at_impact = std::max(at_impact, jump);
      largest = std::max(largest, std::fabs(r.samples[k].ring_current));
    }
    return at_impact / largest;
  };
  const double coarse = change(20e-6), fine = change(5e-6);
  std::printf("ring current at the impact: changes by %.2f %% of its peak in 20 us, by %.2f %% in 5 us\n",
              100 * coarse, 100 * fine);
  CHECK(fine < 0.4 * coarse);
}

TEST_CASE("reciprocity at every edge and corner of a table, on both sides of it") {
  auto design = powbench::bench::reference_contactor();
  design.turns = 1000;
  design.residual_gap = 20e-6;
  TableOptions o;
  o.accuracy = 0.05;
  o.psi_nodes = 14;
  o.gap_nodes = 10;
  Team team(2);
  const TablePotential t(build_table(design, o, team));
  const auto& psi = t.table().psi;
  const auto& gap = t.table().gap;
  double worst = 0;
  for (const double p : {psi[1], psi.back()})
    for (const double g : {0.0, gap[1], gap.back()})
      for (const double side_p : {-1.0, 1.0})
        for (const double side_g : {-1.0, 1.0}) {
          const double dp = 1e-6 * psi.back(), dg = 1e-9;
          const MagneticState s{p + 2 * side_p * dp, 0, g + 2 * side_g * dg};
          const auto at = [&](double a, double b) { return t.at({s.psi + a, 0, s.gap + b}); };
          const double by_psi = (at(dp, 0).pull - at(-dp, 0).pull) / (2 * dp),
                       by_gap = (at(0, dg).current - at(0, -dg).current) / (2 * dg);
          CHECK(t.at(s).current_gap == Approx(by_psi).epsilon(1e-3));
          worst = std::max(worst, std::fabs(by_gap / by_psi - 1));
        }
  std::printf("edges of the table: dF/dpsi and di/dgap by differences agree to %.1e\n", worst);
  CHECK(worst < 1e-4);
}
