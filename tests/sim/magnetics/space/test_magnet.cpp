#include <catch2/catch.hpp>
#include <cmath>

#include "sim/magnetics/space/magnet_field.h"

namespace sim = powbench::sim;

namespace {

sim::space::MagnetField coarse(const sim::MagnetDesign& design = {}) {
  return sim::space::MagnetField(design, sim::space::CoreMeshSizes{}.scaled(4));
}

std::string refusal(const sim::MagnetDesign& design) {
  try {
    coarse(design);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("Pull is the derivative of the energy by the gap, with the ring short-circuited, open and bound") {
  auto field = coarse();
  const double gap = 1e-3, step = 2e-6, psi = 0.5;
  for (const bool open : {true, false}) {
    const double ring = open ? 0 : 0.6e-4;
    field.set_gap(gap - step);
    const auto below = field.at_flux(psi, ring, {}, open);
    field.set_gap(gap + step);
    const auto above = field.at_flux(psi, ring, {}, open);
    field.set_gap(gap);
    const auto here = field.at_flux(psi, ring, {}, open);
    CAPTURE(open);
    CHECK(here.solution.converged);
    CHECK(here.psi == Approx(psi).epsilon(1e-9));
    const auto& r = here.response;
    CHECK(r.pull == Approx((above.response.energy - below.response.energy) / (2 * step)).epsilon(1e-5));
    // reciprocity: both are the mixed derivative of one energy
    CHECK(r.current_gap ==
          Approx((above.response.current - below.response.current) / (2 * step)).epsilon(1e-5));
    if (!open)
      CHECK(r.ring_gap ==
            Approx((above.response.ring_current - below.response.ring_current) / (2 * step)).epsilon(1e-5));
    const auto more = field.at_flux(psi * 1.001, ring, {}, open);
    CHECK(r.current_psi == Approx((more.response.current - r.current) / (0.001 * psi)).epsilon(0.02));
    CHECK(r.current_gap == Approx((more.response.pull - r.pull) / (0.001 * psi)).epsilon(0.02));
    // Maxwell's stress on one layer and virtual work over the strip differ by the error of the mesh
    CHECK(here.stress_pull == Approx(r.pull).epsilon(0.02));
    CHECK(here.stress_pull != r.pull);
  }
}

TEST_CASE("Given the current, the same state comes back as from its flux linkage") {
  auto field = coarse();
  field.set_gap(0.5e-3);
  const auto a = field.at_current(0.3, 5);
  const auto b = field.at_flux(a.psi, a.ring);
  CHECK(b.response.current == Approx(0.3).epsilon(1e-6));
  CHECK(b.response.ring_current == Approx(5).epsilon(1e-5));
  CHECK(b.response.pull == Approx(a.response.pull).epsilon(1e-6));
  const auto mirrored = field.at_current(-0.3, -5);
  CHECK(mirrored.psi == Approx(-a.psi).epsilon(1e-9));
  CHECK(mirrored.response.pull == Approx(a.response.pull).epsilon(1e-9));
}

TEST_CASE("Newton arrives from zero at every gap down to a tenth of a micrometre and far into saturation") {
  sim::MagnetDesign design;
  design.residual_gap = 0.1e-6;
  design.shape.ring_share = 0;
  {
    const char* steel = "team13";
    design.steel = sim::builtin_steel(steel);
    auto field = coarse(design);
    CHECK_FALSE(field.has_ring());
    for (const double gap : {0.0, 6e-3}) {
      field.set_gap(gap);
      for (const double current : {0.01, 10.0}) {
        const auto p = field.at_current(current);
        CAPTURE(steel, gap, current, p.solution.iterations);
        CHECK(p.solution.converged);
        CHECK(p.solution.iterations <= 25);
        CHECK(p.response.pull > 0);
        CHECK(p.response.current_psi > 0);
      }
      const auto bound = field.at_flux(3.0, 0);  // about 5 T in the centre leg
      CAPTURE(steel, gap, bound.solution.iterations);
      CHECK(bound.solution.converged);
      CHECK(bound.solution.iterations <= 25);
    }
  }
}

TEST_CASE("Laminations carry the flux along the sheets and hinder it across them") {
  const auto steel = sim::builtin_steel("lamination");
  const sim::space::MediumLaw stack(sim::space::laminated(steel, 0.95, 1)), block(sim::space::solid(steel));
  const double h = 200;
  CHECK(stack.at({h, 0, 0}).b[0] == Approx(0.95 * block.at({h, 0, 0}).b[0]).epsilon(1e-3));
  CHECK(stack.at({0, h, 0}).b[1] == Approx(20 * 4e-7 * M_PI * h).epsilon(1e-9));
  // the co-energy's derivatives are B and dB/dH
  for (const auto& law : {stack, block}) {
    const sim::Vec3 at{150, 40, -90};
    const auto p = law.at(at);
    for (int k = 0; k < 3; ++k) {
      sim::Vec3 up = at, down = at;
      up[k] += 0.01;
      down[k] -= 0.01;
      const auto a = law.at(up), b = law.at(down);
      CHECK(p.b[k] == Approx((a.coenergy - b.coenergy) / 0.02).epsilon(1e-6));
      CHECK(p.slope[k] == Approx((a.b[k] - b.b[k]) / 0.02).epsilon(1e-5));
    }
    CHECK(p.slope[3] ==
          Approx((law.at({150, 40.01, -90}).b[0] - law.at({150, 39.99, -90}).b[0]) / 0.02).margin(1e-9));
  }
}

TEST_CASE("Impossible cores are refused with key, value and range") {
  sim::MagnetDesign d;
  d.residual_gap = 0;
  CHECK(refusal(d) == "magnet.residual_gap_um = 0.000000, allowed 0.050000 .. 1000.000000");
  d = {};
  d.shape.stack = 18;  // mm given as m
  CHECK(refusal(d).find("shape.stack_mm = 18000, allowed 1 .. 300") != std::string::npos);
  d = {};
  d.shape.ring_slot = 9e-3;
  CHECK(refusal(d).find("shape.ring_slot_mm") != std::string::npos);
  d = {};
  d.shape.coil_width = 12e-3;
  CHECK(refusal(d).find("shape.coil_width_mm = 12") != std::string::npos);
  auto field = coarse();
  CHECK_THROWS_WITH(field.set_gap(-1e-3), Catch::Contains("gap_mm = -1.000000, allowed 0"));
  CHECK_THROWS_AS(field.at_current(std::nan("")), std::invalid_argument);
}
