#include <catch2/catch.hpp>
#include <cmath>

#include "core/quantities.h"
#include "core/random.h"
#include "core/units.h"
#include "dsp/events/extract.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

/// The laser with two counts of noise, held at its value from `from` to `to`, s.
Record held(Record r, double from, double to, powbench::Random& random) {
  for (ChannelRecord& c : r.channels) {
    if (c.channel != Channel::laser) continue;
    std::int16_t last = 0;
    for (std::size_t i = 0; i < c.raw.size(); ++i) {
      c.raw[i] = static_cast<std::int16_t>(std::lround(c.raw[i] + 2 * random.normal()));
      const double t = r.time(i);
      if (t > from && t < to) c.raw[i] = last;
      last = c.raw[i];
    }
  }
  return r;
}

ExtractOptions quick() {
  ExtractOptions o;
  o.ring_modes = 0;
  return o;
}

}  // namespace

TEST_CASE("a laser that holds its value about the landing gives no seat that it did not see") {
  powbench::Random random(5);
  int known = 0, unknown = 0;
  for (int k = 0; k < 12; ++k) {
    Conditions at;
    at.closing_angle = radians(15.0 * k);
    const auto closing = rigs::simulate_record({}, at, {});
    REQUIRE(closing.truth.core_seat.has_value());
    const double seat = *closing.truth.core_seat;
    const CoreEvents sound = extract_events(held(closing.record, 1, 1, random), quick()).core;
    REQUIRE(sound.seat.known());
    CHECK((sound.flags & flag_gap) == 0);
    for (const double begins : {-5e-3, -3e-3, -1.5e-3, -0.3e-3, 0.6e-3}) {
      INFO(15 * k << " deg, held from " << 1e3 * begins << " ms on");
      const CoreEvents e =
          extract_events(held(closing.record, seat + begins, seat + begins + 2e-3, random), quick()).core;
      const bool across = begins < 0 && begins + 2e-3 > 0;
      if (across) CHECK_FALSE(e.seat.known());
      if (!e.seat.known()) {
        CHECK_FALSE(e.impact_velocity.known());
        CHECK_FALSE(e.settled.known());
        CHECK((e.flags & flag_gap) != 0);
        ++unknown;
        continue;
      }
      ++known;
      CHECK(std::abs(e.seat.value - seat) < 4 * e.seat.u);
      CHECK(std::abs(e.impact_velocity.value - sound.impact_velocity.value) <
            4 * std::hypot(e.impact_velocity.u, sound.impact_velocity.u));
    }
  }
  CHECK(known >= 9);
  CHECK(unknown >= 24);
}

TEST_CASE("the largest force of a film that saturates is not known") {
  const auto closing = rigs::simulate_record({}, {}, {});
  const Quantity* peak = find_quantity("F_peak");
  REQUIRE(peak != nullptr);
  const Measured whole = peak->of(extract_events(closing.record, quick()));
  REQUIRE(whole.known());
  Record r = closing.record;
  for (ChannelRecord& c : r.channels) {
    if (c.channel != Channel::pvdf_a && c.channel != Channel::pvdf_b) continue;
    const auto top = static_cast<std::int16_t>(std::lround(0.8 * whole.value / std::abs(c.scale) - c.offset));
    c.clip_high = top, c.clip_low = static_cast<std::int16_t>(-top);
    for (std::int16_t& v : c.raw) v = std::clamp(v, c.clip_low, c.clip_high);
  }
  const Events e = extract_events(r, quick());
  CHECK_FALSE(peak->of(e).known());
  CHECK((e.flags & flag_clipped) != 0);
}
