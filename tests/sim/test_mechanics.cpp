// The contactor's mechanics in states that have exact answers.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/models/contactor_model.h"
#include "sim/models/integrator.h"

using namespace powbench::sim;
using powbench::pi;

namespace {

using Integrator = EventIntegrator<ContactorModel>;

Integrator::State run(Integrator& integrator, double t_end) {
  while (integrator.end() < t_end) REQUIRE(integrator.extend());
  Integrator::State s;
  integrator.state(t_end, s);
  return s;
}

}  // namespace

TEST_CASE("the open contactor is in equilibrium: every acceleration is zero to round-off") {
  for (const double tilt : {0.0, 0.2e-3})
    for (const double spread : {0.0, 0.1e-3}) {
      Specimen s;
      s.bridges.tilt_gap = tilt;
      s.bridges.gap_spread = spread;
      const ContactorModel model(s, {}, {});
      const auto rest = model.rest();
      ContactorModel::State slope{};
      model.derivative(0, rest.data(), slope.data());
      for (int i = 0; i < model.size(); ++i) CHECK(std::fabs(slope[static_cast<std::size_t>(i)]) < 1e-9);
      CHECK(std::fabs(model.stored_energy(rest.data())) < 1e-15);
    }
}

TEST_CASE("equal bridges are one group; tilted or different ones are not") {
  Specimen s;
  CHECK(ContactorModel(s, {}, {}).size() == 6 + 2 + 4);
  s.bridges.tilt_gap = 1e-4;
  CHECK(ContactorModel(s, {}, {}).size() == 6 + 4 + 4);
  s.bridges.gap_spread = 1e-4;
  CHECK(ContactorModel(s, {}, {}).size() == 6 + 3 * 4 + 4);
}

TEST_CASE("free flight on the return spring with friction: travel and velocity against the closed form") {
  Specimen s;
  s.bridges.seat_stiffness = 1e9;
  const auto& core = s.core;
  ContactorModel model(s, {}, {});
  // Displaced by 2 mm and let go: slides backwards, friction pushes forwards, the bridges ride on their
  // seats.
  auto y = model.rest();
  y[ContactorModel::x] = 2e-3;
  y[ContactorModel::first_group] = 2e-3;
  Integrator integrator(model, 1e-10, 1e-3);
  model.flip(0, y.data(), 0);  // stick is left at once: the spring is stronger than the friction
  integrator.restart(0, y, 1e-7);
  const double mass = core.mass + s.bridges.poles * s.bridges.mass;
  const double omega = std::sqrt(core.return_rate / mass);
  const double centre = -(core.return_preload - core.friction) / core.return_rate;
  for (const double t : {1e-3, 3e-3, 6e-3}) {
    const auto state = run(integrator, t);
    CHECK(state[ContactorModel::x] == Approx(centre + (2e-3 - centre) * std::cos(omega * t)).margin(1e-9));
    CHECK(state[ContactorModel::v] == Approx(-(2e-3 - centre) * omega * std::sin(omega * t)).margin(5e-6));
  }
}

TEST_CASE("a displaced base rings at its mode and decays by its damping ratio") {
  Specimen s;
  s.base.damping = 0.05;
  ContactorModel model(s, {}, {});
  auto y = model.rest();
  y[ContactorModel::z] = 1e-4;
  Integrator integrator(model, 1e-10, 1e-3);
  integrator.restart(0, y, 1e-6);
  const double omega = 2 * pi * s.base.hertz;
  const double damped = omega * std::sqrt(1 - 0.05 * 0.05);
  for (const double t : {2e-3, 11e-3, 40e-3}) {
    const double expected = 1e-4 * std::exp(-0.05 * omega * t) *
                            (std::cos(damped * t) + 0.05 * omega / damped * std::sin(damped * t));
    CHECK(run(integrator, t)[ContactorModel::z] == Approx(expected).margin(1e-11));
  }
}

TEST_CASE("friction holds the core: below the friction force nothing moves, not even slowly") {
  Specimen s;
  s.core.return_rate = 10;
  s.core.return_preload = 1;
  s.core.friction = 1.8;
  s.bridges.preload = 0;
  ContactorModel model(s, {}, {});
  auto y = model.rest();
  y[ContactorModel::x] = 1e-3;
  y[ContactorModel::first_group] = 1e-3;
  Integrator integrator(model, 1e-8, 1e-3);
  integrator.restart(0, y, 1e-6);
  const auto later = run(integrator, 0.5);
  CHECK(later[ContactorModel::x] == 1e-3);
  CHECK(later[ContactorModel::v] == 0);
}

TEST_CASE("tilted bridge pressed home: both breaks carry the same force") {
  Specimen s;
  s.bridges.tilt_gap = 0.3e-3;
  ContactorModel model(s, {}, {});
  auto y = model.rest();
  // Holder held by friction where the bridge has 0.8 mm of overtravel; the bridge starts just short of break
  // A.
  s.core.friction = 1000;
  ContactorModel held(s, {}, {});
  y[ContactorModel::x] = s.bridges.gap + 0.8e-3;
  y[ContactorModel::first_group] = s.bridges.gap - 0.01e-3;
  held.flip(0, y.data(), std::uint64_t{1} << 1 | std::uint64_t{1} << 2 | std::uint64_t{1} << 3);
  Integrator integrator(held, 1e-9, 1e-3);
  integrator.restart(0, y, 1e-7);
  const auto late = run(integrator, 2.0);
  PlantSample p;
  held.sample(2.0, late.data(), p);
  const double spring =
      s.bridges.preload + s.bridges.rate * (late[ContactorModel::x] - late[ContactorModel::first_group]);
  CHECK(p.force_a + p.force_b == Approx(spring).epsilon(1e-6));
  CHECK(p.force_a == Approx(p.force_b).epsilon(1e-6));
  const double tilt = late[ContactorModel::first_group + 2];
  CHECK(tilt == Approx(-s.bridges.tilt_gap / (2 * s.bridges.half_length)).epsilon(1e-5));
}
