#include <catch2/catch.hpp>
#include <iostream>

#include "bench/solid/impact_cases.h"

using namespace powbench::bench;

TEST_CASE(
    "elastic bar on a rigid wall, nu = 0, 100 cells long: it stays 2 L / c and leaves as fast as it came") {
  const BarOnWall r = bar_on_wall(100, 0.95, 0.65);
  std::cout << "bar on wall: contact time " << 100 * r.contact_error << " %, kinetic energy after "
            << r.kinetic_low << " .. " << r.kinetic_high << ", hourglass " << r.hourglass
            << " of strain, residual " << r.residual << "\n";
  CHECK(std::fabs(r.contact_error) < 0.015);
  CHECK(r.kinetic_low > 1 - 5e-4);
  CHECK(r.kinetic_high < 1 + 5e-4);
  CHECK(r.hourglass < 0.01);
  CHECK(r.residual < 2e-3);
}

TEST_CASE("confined bar (SDNV100): touch, release, stress and speed of the front") {
  const ConfinedBar r = confined_bar(100);
  const double c = 5801.19;
  std::cout << "confined bar: touch " << 1e6 * r.touch << " us, leave " << 1e6 * r.leave << " us, stress "
            << 1e-6 * r.plateau << " MPa, front " << r.front << " m/s\n";
  CHECK(r.touch == Approx(20e-6).epsilon(5e-3));
  CHECK(r.leave == Approx(88.951e-6).epsilon(0.015));
  CHECK(r.plateau == Approx(4640.95e6).epsilon(0.01));
  CHECK(r.front == Approx(c).epsilon(0.01));
}

TEST_CASE("two equal bars exchange their velocities, whether their nodes meet or not") {
  for (const bool meet : {true, false}) {
    const TwoBars r = two_bars(meet);
    std::cout << "two bars, nodes " << (meet ? "meet" : "do not meet") << ": contact time "
              << 100 * r.contact_error << " %, velocities " << r.v_first << " and " << r.v_second
              << ", force " << 100 * r.force_error << " %, residual " << r.residual << "\n";
    CHECK(std::fabs(r.contact_error) < 0.02);
    CHECK(std::fabs(r.v_first) < 0.01);
    CHECK(r.v_second == Approx(1).epsilon(0.01));
    CHECK(std::fabs(r.force_error) < 0.01);
    CHECK(r.residual < 5e-3);
  }
}

TEST_CASE("first bending frequency of a cantilever, four cells through the thickness") {
  const double error = cantilever_error(4, 20);
  std::cout << "cantilever: frequency " << 100 * error << " % from Euler-Bernoulli\n";
  CHECK(std::fabs(error) < 0.01);
}
