#include "sim/magnetics/plane/solenoid_field.h"
#include "tests/sim/magnetics/plane/four_gaps.h"

using namespace powbench::sim;

namespace {

FieldOptions coarse(double times) {
  FieldOptions o;
  o.sizes = CoreMeshSizes{}.scaled(times);
  return o;
}

}  // namespace

TEST_CASE("four gaps of a core side by side are four gaps, from any start and into saturation", "[fields]") {
  const unsigned seed = GENERATE(11u, 12u);
  MagnetDesign design;
  SECTION("three legs, with leakage of the winding's heads and of the ring's") {
    design.end_leakage = 0.02;
    design.ring_leakage = 2e-8;
    check_four_gaps(CoreGap(design, coarse(6)), 5e-3, 1, design.turns, seed);
  }
  SECTION("two legs") {
    design.shape.legs = 2;
    design.shape.outer_width = design.shape.yoke = 12e-3;
    check_four_gaps(CoreGap(design, coarse(6)), 5e-3, 1, design.turns, seed);
  }
  SECTION("one leg closed: steel goes through the strip that stretches") {
    design.shape.legs = 2;
    design.shape.closed_leg = 1;
    design.shape.outer_width = design.shape.yoke = 12e-3;
    design.shape.ring_share = 0;
    check_four_gaps(CoreGap(design, coarse(6)), 5e-3, 1, design.turns, seed);
  }
  SECTION("elements of the first order") {
    auto o = coarse(5);
    o.order = 1;
    check_four_gaps(CoreGap(design, o), 5e-3, 1, design.turns, seed);
  }
}

TEST_CASE("four gaps of a solenoid side by side are four gaps, with a magnet in its circuit, too",
          "[fields]") {
  SolenoidDesign design;
  if (GENERATE(false, true)) design.shape.magnet_length = 3e-3;
  FieldOptions o;
  o.sizes = sizes_for(0.02);
  check_four_gaps(SolenoidGap(design, o, 0), design.largest_gap, 0.2, design.turns, GENERATE(13u, 14u));
}
