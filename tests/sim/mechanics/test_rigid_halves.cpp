// Eight lanes in two registers give the bits of eight in one.

#include <catch2/catch.hpp>
#include <cstring>

#include "core/random.h"
#include "sim/mechanics/rigid_halves.h"
#include "sim/mechanics/rigid_lanes.h"

#ifdef __x86_64__

using namespace powbench::sim;

namespace {

void draw(powbench::Random& random, Lanes<double>& v, double low, double high) {
  for (int k = 0; k < lane_count; ++k) v[k] = low + (high - low) * random.uniform();
}

/// Any numbers: the equations hold for more than contactors.
RigidLanes<double> drawn(powbench::Random& random) {
  RigidLanes<double> p;
  p.bridges = 1 + static_cast<int>(random.below(8));
  p.modes = static_cast<int>(random.below(3));
  p.dof = 3 + p.modes + 2 * p.bridges;
  p.viscous = random.below(2) == 0;
  p.rooted = random.below(2) == 0;
  p.automatic = random.below(4) == 0;
  p.followed = static_cast<int>(random.below(rigid_contacts + 8)) - 8;
  p.root = random.uniform();
  for (auto* v :
       {&p.at, &p.pad_arm, &p.seat_arm, &p.gap[0], &p.gap[1], &p.preload, &p.rate, &p.damping, &p.turning,
        &p.inverse_mass, &p.inverse_inertia, &p.to_x, &p.to_tilt, &p.to_static, &p.offset})
    draw(random, *v, -1, 1);
  for (auto& mode : p.shape)
    for (auto& v : mode) draw(random, v, -1, 1);
  p.active = p.dented = static_cast<unsigned>(random.below(32));
  for (int g = 0; g < rigid_groups; ++g) {
    for (auto* v : {&p.k[g], &p.linear[g], &p.hertz[g], &p.square[g], &p.lambda[g], &p.c[g],
                    &p.inverse_ramp[g], &p.flat[g]})
      draw(random, *v, 0, 2);
    for (int k = 0; k < lane_count; ++k) p.pressing[g][k] = p.dent[g][k] = random.below(2) == 0 ? 0 : 1;
  }
  p.inverse_core = 3, p.inverse_tilt = 5, p.inverse_static = 2, p.return_rate = 7, p.follow = 1;
  return p;
}

}  // namespace

TEST_CASE("the rigid contactor in halves has the bits of the whole", "[mechanics]") {
  if (!__builtin_cpu_supports("avx2")) return;
  powbench::Random random(77);
  constexpr int most = 96;
  for (int n = 0; n < 2000; ++n) {
    const RigidLanes<double> p = drawn(random);
    Lanes<double> sign[rigid_groups];
    for (auto& s : sign)
      for (int k = 0; k < lane_count; ++k) s[k] = static_cast<double>(random.below(3)) - 1;
    double s[most], whole[most] = {}, halves[most] = {}, lost[2] = {}, lost_too[2] = {};
    for (double& x : s) x = 2 * random.uniform() - 1;
    rigid_rhs(p, s, 0.3, whole, lost);
    rigid_rhs_in_halves(&p, s, 0.3, halves, lost_too);
    REQUIRE(std::memcmp(whole, halves, sizeof whole) == 0);
    REQUIRE(std::memcmp(lost, lost_too, sizeof lost) == 0);
    constexpr int all = rigid_contacts;
    double one[3][all], other[3][all];
    rigid_signed_depths(p, sign, s, s, one[0], one[1], one[2]);
    rigid_guards_in_halves(&p, sign, s, s, other[0], other[1], other[2]);
    REQUIRE(std::memcmp(one, other, sizeof one) == 0);
  }
}

#endif
