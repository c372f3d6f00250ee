#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "sim/magnetics/plane/table_build.h"
#include "sim/models/fields.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/study/circuit_of_field.h"

using namespace powbench::sim;

TEST_CASE("the circuit nearest to a circuit is that circuit, with and without a shading ring", "[study]") {
  Specimen s;
  s.magnet.pole_area = 1.9e-4;
  s.magnet.fringing = 0.8;
  s.magnet.shaded_share = GENERATE(0.0, 0.4);
  s.coil.leakage = 0.11;
  Specimen start;  // knows turns, travel and residual gap alone
  start.magnet.shaded_share = s.magnet.shaded_share;
  Team team(2);
  const SpecimenPotential field(s);
  const CircuitFit fit = identify_circuit(start, field, 1.0, team);
  CAPTURE(fit.all.current_rms, fit.all.current_worst, fit.all.pull_rms, fit.all.pull_worst);
  CHECK(fit.all.current_worst < 1e-3);
  CHECK(fit.all.pull_worst < 1e-3);
  CHECK(fit.specimen.magnet.pole_area == Approx(s.magnet.pole_area).epsilon(1e-3));
  CHECK(fit.specimen.coil.leakage == Approx(s.coil.leakage).epsilon(0.01));
  CHECK(fit.specimen.magnet.shaded_share == Approx(s.magnet.shaded_share).margin(1e-3));
  CHECK(fit.specimen.magnet.residual_gap == s.magnet.residual_gap);
  CHECK(fit.specimen.lumped);
  CHECK(fit.by_gap.size() == 12);
  CHECK(fit.at_end.empty());
  const CircuitFit again = identify_circuit(start, field, 1.0, team);
  CHECK(again.specimen.magnet.pole_area == fit.specimen.magnet.pole_area);
}

TEST_CASE("the circuit of a field is nearer to it than the one the specimen had, and says how near",
          "[study]") {
  const Specimen s;
  TableOptions o;
  o.accuracy = 0.02;
  o.largest_gap = 1.5 * s.core.travel;
  Team team(2);
  const TablePotential field(build_table(magnet_design(s), o, team));
  REQUIRE(field.has_ring());
  const CircuitFit fit = identify_circuit(s, field, 1.2, team);
  CAPTURE(fit.all.current_rms, fit.all.pull_rms, fit.specimen.magnet.shaded_share);
  CHECK(fit.all.current_rms < 0.05);
  CHECK(fit.all.pull_rms < 0.1);
  CHECK(fit.specimen.magnet.shaded_share > 0.3);
  CHECK(fit.specimen.magnet.shaded_share < s.shape.ring_share);
  // states between those of the fit: with current in the ring nearer than before, and without as near as is said
  o.ring = false;
  const TablePotential at_rest(build_table(magnet_design(s), o, team));
  const auto miss = [](const MagneticPotential& of, const MagneticPotential& from, double psi, double ring,
                       double gap) {
    return of.at({psi, ring, gap}).pull / from.at({psi, ring, gap}).pull - 1;
  };
  Specimen open = fit.specimen;
  open.magnet.shaded_share = 0;
  const SpecimenPotential mine(fit.specimen), former(s), resting(open);
  double sum = 0, sum_of_former = 0, squares = 0;
  for (const double psi : {0.35, 0.65, 0.95, 1.15})
    for (const double gap : {0.2e-3, 0.9e-3, 2.4e-3, 3.7e-3}) {
      const double ring = 0.3 * psi / s.coil.turns;
      sum += std::fabs(miss(mine, field, psi, ring, gap));
      sum_of_former += std::fabs(miss(former, field, psi, ring, gap));
      squares += std::pow(miss(resting, at_rest, psi, 0, gap), 2);
    }
  CAPTURE(sum, sum_of_former, squares);
  CHECK(sum < 0.6 * sum_of_former);
  CHECK(std::sqrt(squares / 16) < 1.5 * fit.all.pull_rms);
}

TEST_CASE("a circuit whose fringing is beyond what is sought says so", "[study]") {
  Specimen s;
  s.magnet.fringing = 40;
  s.magnet.shaded_share = 0;
  Team team(2);
  const CircuitFit fit = identify_circuit(Specimen{}, SpecimenPotential(s), 1.0, team);
  CHECK(std::count(fit.at_end.begin(), fit.at_end.end(), "fringing") == 1);
  CHECK(fit.all.pull_worst > 0.01);
}

TEST_CASE("a field through which no flux goes has no circuit", "[study]") {
  struct Nothing final : MagneticPotential {
    bool has_ring() const override { return false; }
    MagneticResponse at(const MagneticState&) const override { return {}; }
  };
  Team team(1);
  CHECK_THROWS_AS(identify_circuit(Specimen{}, Nothing{}, 1.0, team), std::invalid_argument);
}
