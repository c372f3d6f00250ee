// The supply of the rig file feeds the simulated closing and the simulated rig alike.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "rigs/registry.h"
#include "rigs/rig.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::rigs;
using namespace std::chrono_literals;

namespace {

double largest(const Record& r, Channel channel, double from, double to) {
  const auto& c = *r.find(channel);
  double most = 0;
  for (std::size_t n = 0; n < r.samples(); ++n) {
    const double t = (static_cast<double>(n) - static_cast<double>(r.fire_sample)) / r.sample_rate;
    if (t >= from && t < to) most = std::max(most, std::fabs(c.value(n)));
  }
  return most;
}

}  // namespace

TEST_CASE("a simulated record behind a relay: no current during the delay, the closing that much later",
          "[rig]") {
  Conditions late, plain;
  late.closing_angle = radians(30.0);
  plain.closing_angle = radians(84.0);
  SimRigConfig relay;
  relay.supply.coil_switch.kind = sim::CoilSwitch::Kind::relay;
  relay.supply.coil_switch.closing_delay = 3e-3;  // 54 deg
  const auto a = simulate_record({}, late, relay), b = simulate_record({}, plain, {});
  CHECK(*a.truth.touch == Approx(*b.truth.touch + 3e-3).margin(2e-6));
  CHECK(largest(a.record, Channel::coil_current, 0, 2.9e-3) < 1e-3);
  CHECK(largest(a.record, Channel::coil_current, 3.1e-3, 20e-3) > 0.05);
}

TEST_CASE("the simulated rig's mains dips after switch-on, as its channels show", "[rig]") {
  SimRigConfig config;
  config.supply.mains.dips[0] = {25e-3, 20e-3, 0.5, 0};
  config.supply.mains.harmonics[0].share = 0.1;
  const auto rig = open("sim:", config, {});
  Conditions c;
  c.closing_angle = radians(90.0);
  const Shot shot = rig->fire(c, 5s);
  REQUIRE(shot.outcome == Outcome::pass);
  const double full = largest(shot.record, Channel::mains_voltage, 1e-3, 24e-3);
  const double dipped = largest(shot.record, Channel::mains_voltage, 26e-3, 44e-3);
  CHECK(dipped == Approx(0.5 * full).epsilon(0.02));
  // the third harmonic takes a tenth off the crest
  CHECK(full == Approx(0.9 * 230 * std::sqrt(2.0)).epsilon(0.03));
}
