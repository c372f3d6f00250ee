// What feeds the coil is the same on every rung, and a rung that cannot model it says so.

#include <catch2/catch.hpp>
#include <cmath>

#include "core/units.h"
#include "sim/models/mechanics.h"
#include "sim/study/metrics.h"
#include "sim/study/scene_choice.h"

using namespace powbench;
using namespace powbench::sim;

namespace {

Case weak_mains() {
  Case c;
  c.conditions.closing_angle = radians(40.0);
  c.bench.mains.resistance = 40;
  c.bench.mains.inductance = 0.05;
  c.bench.mains.harmonics[1].share = 0.08;
  return c;
}

double touch(const Rung& rung, const Case& c, double setting) {
  return rung.run(c, 0.04, setting, 0).truth.touch.value();
}

}  // namespace

TEST_CASE("a weak source is seen by every rung that knows it", "[rungs]") {
  const Case weak = weak_mains();
  Case plain = weak;
  plain.bench = {};
  const auto shared =
      pure_field("table", "the circuit as a potential of its own", circuit_field().potential(plain));
  const Rung plant = scene_rung(circuit_field(), "plant");
  const double late = touch(plant, weak, 1e-8) - touch(plant, plain, 1e-8);
  CHECK(late > 50e-6);
  for (const Rung& rung : {scene_rung(circuit_field(), "rigid"), scene_rung(shared, "rigid")}) {
    CAPTURE(rung.name());
    CHECK(touch(rung, weak, 1e-8) - touch(rung, plain, 1e-8) == Approx(late).margin(2e-6));
  }
  const MetricOptions options;
  CHECK(closing_metrics(weak, options).touch - closing_metrics(plain, options).touch ==
        Approx(late).margin(2e-6));
}

TEST_CASE("a closing tells how much of it lay outside of what its fields were made from", "[rungs]") {
  /// The circuit, known for gaps up to `end` only.
  struct Short final : MagneticPotential {
    Short(std::shared_ptr<const MagneticPotential> of, double to) : whole(std::move(of)), end(to) {}
    bool has_ring() const override { return whole->has_ring(); }
    MagneticResponse at(const MagneticState& s) const override {
      MagneticResponse r = whole->at(s);
      r.beyond = s.gap > end;
      return r;
    }
    std::shared_ptr<const MagneticPotential> whole;
    double end;
  };
  const Case c;
  const auto whole = circuit_field().potential(c);
  const auto run = [&](double share, const char* mechanics) {
    const auto fields =
        pure_field("table", "a table", std::make_shared<Short>(whole, share * c.specimen.core.travel));
    const Rung rung = scene_rung(fields, mechanics);
    return rung.run(c, 0.02, rung.settings.empty() ? 1e-6 : rung.settings.front(), 0);
  };
  for (const char* mechanics : {"rigid", "modal"}) {
    CAPTURE(mechanics);
    const Trajectory all = run(1.5, mechanics), half = run(0.5, mechanics), none = run(-1, mechanics);
    CHECK(all.field_states > 100);
    CHECK(all.field_beyond == 0);
    CHECK((half.field_beyond > 0 && half.field_beyond < half.field_states));
    CHECK(none.field_beyond == none.field_states);
    CHECK(half.truth.touch == all.truth.touch);  // told, not changed
  }
}

TEST_CASE("a rung refuses what it does not model", "[rungs]") {
  const auto words = [](const char* mechanics, const Case& c) {
    const Rung rung = scene_rung(circuit_field(), mechanics);
    try {
      rung.run(c, 0.01, rung.settings.empty() ? 1e-6 : rung.settings.front(), 0);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string("ran");
  };
  Case relay, remanent, floating, released;
  relay.bench.coil_switch.kind = CoilSwitch::Kind::relay;
  remanent.specimen.magnet.coercive_field = 60;
  floating.specimen.base.core_mass = 0.2;
  released.conditions.hold_time = 0.01;
  const auto says = [](const char* text) { return Catch::Matchers::StartsWith(text); };
  for (const char* mechanics : {"modal", "deformable"}) {
    CAPTURE(mechanics);
    CHECK_THAT(words(mechanics, weak_mains()), says("supply, switch: "));
    CHECK_THAT(words(mechanics, relay), says("supply, switch: "));
    CHECK_THAT(words(mechanics, remanent), says("magnet.coercive_field_A_per_m: allowed 0"));
    CHECK_THAT(words(mechanics, floating), says("base.core_mass_g"));
  }
  CHECK_THAT(words("deformable", released), says("hold_time: allowed from 30"));
  CHECK(words("modal", released) == "ran");
  for (const char* mechanics : {"plant", "rigid"})
    for (const Case& c : {weak_mains(), relay, remanent, released}) CHECK(words(mechanics, c) == "ran");
}

TEST_CASE("the deformable rung takes coil temperature and polarity as the others do", "[rungs]") {
  Case c;
  c.conditions.closing_angle = radians(40.0);
  Case turned = c;  // half a turn later and the other way round: the same closing
  turned.conditions.closing_angle += pi;
  turned.conditions.polarity = -1;
  Case hot = c;
  hot.conditions.ambient = zero_celsius + 60;
  const Rung rung = scene_rung(circuit_field(), "deformable");
  const auto current = [&](const Case& q) { return rung.run(q, 4e-3, 6, 1e-3).samples.back().coil_current; };
  CHECK(current(turned) == Approx(current(c)).epsilon(1e-12));
  const Rung rigid = scene_rung(circuit_field(), "rigid");
  const auto reference = [&](const Case& q) {
    return rigid.run(q, 4e-3, 1e-8, 1e-3).samples.back().coil_current;
  };
  const double change = reference(hot) / reference(c) - 1;
  CHECK(change < -1e-4);
  CHECK(current(hot) / current(c) - 1 == Approx(change).epsilon(0.05));
}

TEST_CASE("the deformable rung's openings last from a release to the next touch", "[.slow][rungs]") {
  Case c;
  c.conditions.closing_angle = radians(40.0);
  const Trajectory t = scene_rung(circuit_field(), "deformable").run(c, 30e-3, 6, 1e-3);
  REQUIRE(t.truth.touch);
  REQUIRE_FALSE(t.truth.openings.empty());
  double closed_since = *t.truth.touch;
  for (const Opening& o : t.truth.openings) {
    CHECK(o.release >= closed_since);
    CHECK(o.touch > o.release);
    closed_since = o.touch;
  }
  CHECK(t.truth.settled == closed_since);
}
