// Iron that remembers: the law itself, and what it does to switching on, holding and opening.

#include "sim/specimen/specimen_remanence.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/models/rigid_closing.h"
#include "sim/specimen/specimen_potential.h"
#include "tests/sim/supply/supply_cases.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

Specimen magnetic(double coercive_field, double residual_gap = 36e-6) {
  Specimen s;
  s.magnet.coercive_field = coercive_field;
  s.magnet.coercive_span = 0.05;
  s.magnet.residual_gap = residual_gap;
  return s;
}

/// N, of all springs on the closed core.
double opening_force(const Specimen& s) {
  const auto& b = s.bridges;
  return s.core.return_preload + s.core.return_rate * s.core.travel +
         b.poles * (b.preload + b.rate * (s.core.travel - b.gap));
}

/// N, of the closed core without current, after a large positive flux.
double hold_force(const Specimen& s) {
  const SpecimenPotential p(s);
  return p.at(remanent_state(p, -remanence(s).current, 0)).pull;
}

Conditions switched_off(double degrees) {
  Conditions c = at_angle(degrees);
  c.hold_time = 0.08;
  return c;
}

}  // namespace

TEST_CASE("remanence: the closed form follows the rate, work is stored or lost, and nothing is gained") {
  const Remanence r{0.01, 0.2, 0};
  double offset = 0, work = 0, lost = 0, psi = 0;
  constexpr double step = 1e-5;
  for (const double goal : {0.7, -0.5, 0.1, -0.1, 0.9, 0.0}) {
    const double start = offset, from = psi;
    const double sign = goal > psi ? 1 : -1;
    while (sign * (goal - psi) > step / 2) {  // midpoint rule
      const double middle = offset + 0.5 * step * r.rate(offset, sign);
      work += middle * sign * step;
      lost += step * r.loss(middle, sign);
      offset += step * r.rate(middle, sign);
      psi += sign * step;
    }
    CHECK(offset == Approx(r.after(start, psi - from)).margin(1e-12));
    CHECK(std::fabs(offset) <= r.current);
    CHECK(work == Approx(lost + r.stored(offset)).margin(1e-11));
  }
  CHECK(lost > 0.02);
}

TEST_CASE("remanence: a wide loop loses 2 i_c for each weber it turns through, there and back") {
  const Remanence r{0.01, 0.01, 0};
  double offset = r.after(0, 5.0), lost = 0;
  constexpr double step = 1e-5;
  for (int k = 0; k < 200000; ++k) {
    const double sign = k < 100000 ? -1 : 1;
    const double middle = offset + 0.5 * step * r.rate(offset, sign);
    lost += step * r.loss(middle, sign);
    offset += step * r.rate(middle, sign);
  }
  // i_c times 2 Wb, less what the turning over at both ends does not use: psi_c (1 + 2 - 1/2) ... of i_c each
  CHECK(lost == Approx(r.current * 2.0).epsilon(0.03));
  CHECK(lost < r.current * 2.0);
}

TEST_CASE("flux without current: i_c times the inductance in linear iron, its pull that of the potential") {
  Specimen s = plain_coil();
  s.magnet.coercive_field = 60;
  s.magnet.remanence = 1;
  const double expected = remanence(s).current * open_inductance(s);
  std::vector<PlantSample> out(1);
  const std::vector<double> times{1e-3};
  Plant plant(s, {}, {});
  plant.advance(2e-3, times, out);
  CHECK(out[0].flux_linkage == Approx(expected).epsilon(1e-12));
  CHECK(out[0].coil_current == 0);
  CHECK(out[0].pull > 0);
  s.magnet.remanence = -0.5;
  Plant other(s, {}, {});
  other.advance(2e-3, times, out);
  CHECK(out[0].flux_linkage == Approx(-0.5 * expected).epsilon(1e-12));
}

TEST_CASE("flux doubling with remanence: what the iron remembers comes on top") {
  Specimen s = plain_coil();
  s.coil.resistance = 1e-3;
  s.magnet.coercive_field = 2000;
  for (const double share : {-1.0, 0.0, 1.0}) {
    s.magnet.remanence = share;
    const double once = std::sqrt(2.0) * 230 / (2 * pi * 50);
    const double left = share * remanence(s).current * open_inductance(s);
    for (const double angle : {0.0, 60.0, 90.0}) {
      double most = 0;
      for (const auto& p : simulate(s, at_angle(angle), 0.01, 1e-5, 1e-10).samples)
        most = std::max(most, p.flux_linkage);
      CHECK(most == Approx(left + once * (1 + std::cos(radians(angle)))).epsilon(1e-4));
    }
  }
}

TEST_CASE(
    "theta and theta + 180 deg: alike without remanence, apart with it, alike again with the other sign") {
  const auto touch = [](double degrees, double share) {
    Specimen s = magnetic(400);
    s.magnet.remanence = share;
    return *simulate(s, at_angle(degrees), 0.06, 0, 1e-10).truth.touch;
  };
  double largest = 0;
  for (const double degrees : {0.0, 50.0, 120.0}) {
    CHECK(touch(degrees, 0) == Approx(touch(degrees + 180, 0)).margin(1e-9));
    const double apart = std::fabs(touch(degrees, 1) - touch(degrees + 180, 1));
    CHECK(apart > 2e-8);
    largest = std::max(largest, apart);
    CHECK(touch(degrees, 1) == Approx(touch(degrees + 180, -1)).margin(1e-9));
  }
  CHECK(largest > 2e-6);
}

TEST_CASE("remanence in both models: every event the same, and both ledgers closed") {
  for (const double degrees : {20.0, 110.0}) {
    Specimen s = magnetic(80);
    s.magnet.remanence = 0.6;
    Supply bench;
    bench.coil_switch.kind = CoilSwitch::Kind::triac;  // cuts the current with a flux that turns on the way
    bench.coil_switch.latching_current = 0.03;
    bench.coil_switch.holding_current = 0.02;
    const auto first = simulate(s, switched_off(degrees), 0.14, 1e-3, 1e-11, bench);
    const auto rigid = simulate_rigid(s, switched_off(degrees), 0.14, 1e-3, 1e-10, true, bench);
    REQUIRE((first.truth.opened && rigid.truth.opened));
    CHECK(*rigid.truth.touch == Approx(*first.truth.touch).margin(1e-8));
    CHECK(*rigid.truth.core_seat == Approx(*first.truth.core_seat).margin(1e-8));
    CHECK(*rigid.truth.opened == Approx(*first.truth.opened).margin(1e-7));
    CHECK(first.energy_residual < 1e-6);
    CHECK(rigid.energy_residual < 1e-6);
    for (std::size_t k = 0; k < 100; ++k) {
      CHECK(rigid.samples[k].flux_linkage == Approx(first.samples[k].flux_linkage).margin(1e-6));
      CHECK(rigid.samples[k].coil_voltage == Approx(first.samples[k].coil_voltage).margin(1e-2));
    }
  }
}

TEST_CASE("release: the more the iron holds the later the pole opens") {
  double last = 0;
  for (const double field : {0.0, 40.0, 80.0, 120.0}) {
    const auto t = simulate(magnetic(field), switched_off(60), 0.2, 0, 1e-9).truth;
    REQUIRE(t.opened);
    CHECK(*t.opened > last);
    last = *t.opened;
  }
}

TEST_CASE(
    "sticking: the core stays where its remanent pull exceeds the springs, and leaves where it does not") {
  for (const double residual : {10e-6, 36e-6}) {
    double low = 1, high = 3000;  // A/m, of equal forces
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (hold_force(magnetic(middle, residual)) < opening_force(magnetic(middle)) ? low : high) = middle;
    }
    CHECK(low < 2999);
    // the springs of stop and mounting, let go with the current, shake a core that is held barely
    const auto weak = simulate(magnetic(0.75 * low, residual), switched_off(60), 0.4, 1e-3, 1e-8);
    CHECK(weak.truth.opened);
    CHECK(std::fabs(weak.samples.back().travel) < 1e-4);
    const auto strong = simulate(magnetic(2 * low, residual), switched_off(60), 0.4, 1e-3, 1e-10);
    CHECK_FALSE(strong.truth.opened);
    CHECK(strong.samples.back().coil_current == 0);
    CHECK(strong.samples.back().pull > opening_force(magnetic(0)) - 2 * Specimen{}.core.friction);
    CHECK(strong.samples.back().travel - strong.samples.back().base > 0.999 * Specimen{}.core.travel);
    CHECK(strong.energy_residual < 1e-6);
  }
}

TEST_CASE("an opened contactor comes to rest with its flux, and the next closing depends on its sign") {
  const Specimen s = magnetic(100);
  const auto second_touch = [&](double degrees) {
    Plant plant(s, closing_mains(at_angle(60)), {1e-10, 293.15});
    plant.gate(true);
    plant.advance(0.08, {}, {});
    plant.gate(false);
    plant.advance(1.0, {}, {});
    const auto cost = plant.evaluations();
    plant.advance(2.0 + radians(degrees - 60) / (2 * pi * 50), {}, {});
    CHECK(plant.evaluations() == cost);  // at rest
    const std::size_t before = plant.events().size();
    const double on = plant.now();
    plant.gate(true);
    plant.advance(on + 0.06, {}, {});
    CHECK(plant.energy_residual() < 1e-6);
    for (std::size_t k = before; k < plant.events().size(); ++k)
      if (plant.events()[k].kind == PlantEvent::Kind::touch_a) return plant.events()[k].time - on;
    return 0.0;
  };
  const double a = second_touch(100), b = second_touch(280);
  CHECK(a > 0);
  CHECK(b > 0);
  CHECK(std::fabs(a - b) > 1e-6);
}
