// What the contact numbers of a specimen file say, in a drop test: the moving parts fly against pads and stop without
// springs worth the name; speed of separation over speed of approach is the restitution that the file gives.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/mechanics/event_solver.h"
#include "sim/mechanics/rigid_contactor.h"
#include "sim/mechanics/unilateral.h"
#include "sim/models/rigid_closing.h"
#include "sim/study/parameter.h"

using namespace powbench::sim;

namespace {

struct Rebounds {
  double pad = -1, stop = -1;
};

/// Core and bridges are thrown from rest with `speed`.
Rebounds drop(Specimen s, double speed, bool to_the_stop) {
  s.core.return_preload = s.bridges.preload = 0.1;
  s.core.return_rate = s.bridges.rate = 1;
  s.core.friction = 0;
  s.core.travel =
      std::max(s.core.travel, s.bridges.gap + 2e-3);  // one impact is over before the other begins
  s.base.hertz = s.base.core_hertz = 0.1;
  s.base.damping = s.base.core_damping = 0;
  s.base.flex_modes = 0;
  RigidContactor<double> c(rigid_parts(s));
  EventSolver<RigidContactor<double>> solver(c, 1e-10, 1e-4);
  alignas(64) double y[EventSolver<RigidContactor<double>>::capacity] = {};
  c.equilibrium(y);
  y[c.dof()] = speed;
  for (int b = 0; b < c.bridges(); ++b) y[c.dof() + c.bridge_state(b)] = speed;
  solver.restart(0, y, 1e-6);
  Rebounds r;
  double pad = 0, stop = 0;
  std::size_t seen = 0;
  while ((to_the_stop ? r.stop : r.pad) < 0 && solver.end() < 0.01) {
    if (!solver.extend()) return r;
    for (; seen < c.events().size(); ++seen) {
      const RigidEvent& e = c.events()[seen];
      const auto place = contact_place(e.contact);
      if (place.part != 0 || place.end != 0) continue;
      const bool is_pad = place.kind == ContactKind::pad, is_stop = place.kind == ContactKind::pole;
      if (is_pad && e.closes && pad == 0) pad = e.speed;
      if (is_pad && !e.closes && r.pad < 0 && pad > 0) r.pad = e.speed / pad;
      if (is_stop && e.closes && stop == 0) stop = e.speed;
      if (is_stop && !e.closes && r.stop < 0 && stop > 0) r.stop = e.speed / stop;
    }
  }
  return r;
}

Specimen drawn(powbench::Random& random) {
  const auto parameters = catalogue_parameters();
  for (;;) {
    std::vector<double> place(parameters.size());
    for (double& x : place) x = random.uniform();
    const Specimen s = specimen_at({}, parameters, place);
    if (s.bridges.gap < s.core.travel - 1e-4) return s;
  }
}

}  // namespace

TEST_CASE("a drop test rebounds with the restitution of the specimen, whatever the masses", "[mechanics]") {
  powbench::Random random(2026);
  double worst_pad = 0, worst_stop = 0;
  for (int k = 0; k < 200; ++k) {
    Specimen s = drawn(random);
    s.bridges.poles = 1;  // the fixed contacts carry one bridge, as the effective mass says
    if (k % 3 == 1) s.bridges.contact_exponent = s.core.stop_exponent = 1.5;
    if (k % 3 == 2) s.bridges.contact_exponent = s.core.stop_exponent = 2;
    s.core.stop_restitution = 0.05 + 0.9 * random.uniform();
    if (k % 2 == 1) s.base.core_mass = 0.08 + 0.24 * random.uniform();
    constexpr double speed = 3;  // m/s: springs take below 1 % of it on the way
    s.bridges.contact_speed = s.core.stop_speed = speed;
    Rebounds r = drop(s, speed, false);
    s.bridges.mass = 1e-4;  // bridges that bounce beside the core would take part in its impact
    r.stop = drop(s, speed, true).stop;
    CAPTURE(k, s.bridges.contact_exponent, s.bridges.contact_restitution, s.core.stop_restitution);
    CHECK(r.pad == Approx(s.bridges.contact_restitution).epsilon(0.01));
    CHECK(r.stop == Approx(s.core.stop_restitution).epsilon(0.01));
    worst_pad = std::max(worst_pad, std::fabs(r.pad / s.bridges.contact_restitution - 1));
    worst_stop = std::max(worst_stop, std::fabs(r.stop / s.core.stop_restitution - 1));
  }
  std::printf("drop tests of 200 specimens: pads within %.1e, stop within %.1e of the number given\n",
              worst_pad, worst_stop);
}

TEST_CASE("rebound and damping ratio are each other's inverse, through critical damping and beyond",
          "[mechanics]") {
  for (double e : {1.0, 0.999, 0.8, 0.5, 0.2, std::exp(-2.0), 0.1354, 0.135, 0.1, 0.01, 1e-3})
    CHECK(rebound_ratio(rebound_damping_ratio(e)) == Approx(e).epsilon(1e-12));
  CHECK(rebound_damping_ratio(std::exp(-2.0)) == Approx(1).epsilon(1e-7));
}

TEST_CASE("numbers of former files move as they did: conversion by effective mass", "[mechanics]") {
  Specimen former;
  former.core.stop_restitution = 0.1;
  former.bridges.contact_restitution = 0.465;
  former.bridges.seat_damping = 0.1;
  const Specimen now = with_rebounds(former);
  // c = 2 zeta sqrt(k m), zeta = -ln e / sqrt(pi^2 + ln^2 e), m the whole core or bridge
  CHECK(stop_damping(now) == Approx(2 * 0.5911550338 * std::sqrt(3.14e7 * 0.1995)).epsilon(1e-9));
  CHECK(pad_damping(now) == Approx(2 * 0.2368031565 * std::sqrt(2.86e6 * 7.76e-3)).epsilon(1e-9));
  CHECK(seat_damping(now) == Approx(2 * 0.1 * std::sqrt(1.667e6 * 7.76e-3)).epsilon(1e-12));
  // the committed reference is such a conversion, to eight digits
  CHECK(now.core.stop_restitution == Approx(Specimen{}.core.stop_restitution).epsilon(1e-7));
  CHECK(now.bridges.contact_restitution == Approx(Specimen{}.bridges.contact_restitution).epsilon(1e-7));
  CHECK(now.bridges.seat_damping == Approx(Specimen{}.bridges.seat_damping).epsilon(1e-7));
}
