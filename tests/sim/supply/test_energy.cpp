// The energy of a whole switch-on, over the closing angles, on every rung.

#include <catch2/catch.hpp>
#include <cstdio>

#include "bench/supply/energy_cases.h"

using namespace powbench::bench;

namespace {

void judge(const EnergyRow& r) {
  std::printf("  %-34s %2d closings, %2d seated, residual %.1e\n", r.method.c_str(), r.closings, r.seated,
              r.residual);
  CAPTURE(r.method);
  CHECK(r.residual <= r.limit);
  CHECK(r.supplied > 0.05);
  CHECK(r.seated > 0);
}

}  // namespace

TEST_CASE("u i = R i^2 + stored + mechanical + ring loss to 1e-6 on the circuits, at every angle") {
  for (const auto& r : circuit_rows(15, 1e-9)) judge(r);
  judge(potential_row("circuit of the shape", *shape_circuit(), 15, 1e-9));
}

TEST_CASE(
    "the energy balance to 1e-6 behind weak mains, relay and triac, and with remanence, on and off again") {
  for (const auto& r : supply_rows(45, 1e-9)) judge(r);
}

TEST_CASE("the energy balance to 1e-6 on a table") {
  judge(potential_row("table", *coarse_table(false), 30, 1e-9));
}

TEST_CASE("the energy balance to 1e-3 with the field itself in the loop", "[.slow]") {
  judge(field_row(60, 100e-6, true));
}
