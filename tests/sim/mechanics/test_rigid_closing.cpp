// The rigid contactor: its equilibrium, the reference closing, restart, numbering, and what it refuses.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "bench/mechanics/reference_closing.h"
#include "sim/mechanics/bounce_error.h"

namespace {

using namespace powbench::sim;
using Contactor = RigidContactor<double>;
using Solver = EventSolver<Contactor>;

struct State {
  alignas(64) double y[Solver::capacity] = {};
};

std::vector<RigidEvent> close(const RigidParts& parts, double tolerance, double end = 0.06) {
  Contactor c(parts);
  State s;
  c.equilibrium(s.y);
  Solver solver(c, tolerance, 1e-3);
  solver.restart(0, s.y, 1e-6);
  while (solver.end() < end) REQUIRE(solver.extend());
  return c.events();
}

}  // namespace

TEST_CASE("the closing starts from static equilibrium", "[mechanics]") {
  Contactor c(powbench::bench::reference_closing());
  State s;
  const double left = c.equilibrium(s.y);
  std::printf("  largest acceleration at t = 0: %.1e m/s2\n", left);
  CHECK(left < 1e-6);
  for (int contact = 0; contact < rigid_contacts; ++contact) {
    if (!c.uses(contact)) continue;
    const auto kind = contact_place(contact).kind;
    CHECK(c.is_pressing(contact) == (kind == ContactKind::seat || kind == ContactKind::stop));
  }
}

TEST_CASE("all 170 bounces of the reference closing, each within 3e-8 s", "[mechanics]") {
  RigidContactor<long double> exact(powbench::bench::reference_closing());
  alignas(64) long double y[EventSolver<RigidContactor<long double>>::capacity] = {};
  exact.equilibrium(y);
  EventSolver<RigidContactor<long double>> solver(exact, 1e-12L, 1e-3L);
  solver.restart(0, y, 1e-6L);
  while (solver.end() < 0.06L) REQUIRE(solver.extend());
  const auto events = close(powbench::bench::reference_closing(), 1e-9);
  const auto e = bounce_error(events, exact.events(), 0.06);
  std::printf("  %d of %d events, largest dt %.1e s, contact states differ for %.1e s\n", e.matched,
              e.reference, e.largest_dt, e.distance);
  CHECK(e.reference == 170);
  CHECK(e.matched == 170);
  CHECK(e.largest_dt < 3e-8);
  const auto first = std::find_if(events.begin(), events.end(), [](const RigidEvent& v) {
    return is_bounce(v) && contact_place(v.contact).part < 3;
  });
  CHECK(first->time == Approx(26.823442e-3).epsilon(1e-7));
  const auto core = std::find_if(events.begin(), events.end(), [](const RigidEvent& v) {
    return contact_place(v.contact).kind == ContactKind::pole;
  });
  CHECK(core->time == Approx(29.002637e-3).epsilon(1e-7));
}

TEST_CASE("a restart from a snapshot continues bit for bit", "[mechanics]") {
  Contactor c(powbench::bench::reference_closing());
  State s;
  c.equilibrium(s.y);
  Solver solver(c, 1e-7, 1e-3);
  solver.restart(0, s.y, 1e-6);
  while (solver.end() < 0.0275) REQUIRE(solver.extend());
  Contactor twin = c;  // the modes
  Solver resumed(twin, 1e-7, 1e-3);
  resumed.resume(solver.memory());
  for (int k = 0; k < 300; ++k) {
    REQUIRE(solver.extend());
    REQUIRE(resumed.extend());
  }
  CHECK(solver.end() == resumed.end());
  CHECK(std::memcmp(solver.end_state(), resumed.end_state(), sizeof(double) * 34) == 0);
  REQUIRE(c.events().size() == twin.events().size());
  CHECK(c.events().size() > 100);
  CHECK(c.events().back().time == twin.events().back().time);
}

TEST_CASE("six pads that touch at once flip in one event", "[mechanics]") {
  auto parts = powbench::bench::reference_closing();
  parts.bridges.resize(3);
  parts.modes.clear();
  for (auto& b : parts.bridges) {
    b = parts.bridges[1];
    b.position = 0;
    b.gap[0] = b.gap[1] = 3e-3;
  }
  const auto events = close(parts, 1e-8, 0.04);
  std::vector<double> first;
  for (const auto& e : events)
    if (contact_place(e.contact).kind == ContactKind::pad && first.size() < 6) {
      CHECK(e.closes);
      first.push_back(e.time);
    }
  REQUIRE(first.size() == 6);
  CHECK(first.back() - first.front() == 0.0);
}

TEST_CASE("a level bridge does not spin, a tilted one is turned back", "[mechanics]") {
  auto parts = powbench::bench::reference_closing();
  parts.bridges = {parts.bridges[1]};
  parts.bridges[0].gap[0] = parts.bridges[0].gap[1] = 3e-3;
  parts.modes.clear();
  Contactor c(parts);
  c.follow_depths(true);
  alignas(64) double dy[Solver::capacity] = {};
  State s;
  s.y[0] = 3.2e-3;
  s.y[3] = 3.01e-3;  // both pads pressed by 10 um
  c.derivative(0, s.y, dy);
  const int turn = c.dof() + 4;
  CHECK(dy[turn] == 0.0);
  CHECK(dy[turn - 1] < -100);
  s.y[4] = 2e-4;
  c.derivative(0, s.y, dy);
  CHECK(dy[turn] < -1e3);
}

TEST_CASE("impossible parts are refused with key, value and range", "[mechanics]") {
  const auto refuses = [](auto change, const char* words) {
    auto p = powbench::bench::reference_closing();
    change(p);
    CHECK_THROWS_WITH(Contactor(p), Catch::Contains(words));
  };
  refuses([](RigidParts& p) { p.core_mass = -0.1; }, "core_mass = -0.1, allowed above 0");
  refuses([](RigidParts& p) { p.pad.stiffness = 0; }, "pad.stiffness = 0, allowed above 0");
  refuses([](RigidParts& p) { p.bridges[1].gap[0] = -1e-4; }, "parts overlap at t = 0");
  refuses([](RigidParts& p) { p.bridges[4].mass = std::nan(""); }, "bridge 5.mass = nan");
  refuses([](RigidParts& p) { p.pole.exponent = 1.7; }, "pole.exponent = 1.7, allowed 1, 1.5 and 2");
  refuses([](RigidParts& p) { p.seat = {1e8, 1.5, DampingForm::flores, 0, 0}; }, "seat.damping = 0");
  refuses([](RigidParts& p) { p.modes[2].hertz = 0; }, "mode 3.hertz = 0");
}
