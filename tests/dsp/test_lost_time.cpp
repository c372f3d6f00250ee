// What a record does not show: lost samples, an end that comes too early, spikes, a sense voltage turned round.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/random.h"
#include "core/units.h"
#include "dsp/events/extract.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

constexpr double rate = 200e3, before = 0.045;

/// Sine from 10.0 to 11.5 ms, then closed from 11.9 ms on.
double force_at(double t) {
  if (t > 10e-3 && t < 11.5e-3) return 20 * std::sin(pi * (t - 10e-3) / 1.5e-3);
  if (t <= 11.9e-3) return 0;
  return t < 12.3e-3 ? 15 * std::sin(pi / 2 * (t - 11.9e-3) / 0.4e-3) : 15;
}

double sense_at(double t) {
  return (t > 10e-3 && t < 11.5e-3) || t > 11.9e-3 ? 0.0 : 6.0;
}

using Curve = std::function<double(double)>;

void add(Record& r, Channel channel, double scale, double noise, double end, const Curve& curve) {
  Random random(static_cast<std::uint64_t>(channel) + 5);
  ChannelRecord c;
  c.channel = channel;
  c.scale = scale;
  const auto n = static_cast<int>(std::lround((before + end) * rate));
  for (int i = 0; i < n; ++i) {
    const double v = curve((i - before * rate) / rate) + noise * random.normal();
    c.raw.push_back(static_cast<std::int16_t>(std::lround(v / scale)));
  }
  r.channels.push_back(std::move(c));
}

Record record(double end = 0.06, const Curve& force = force_at) {
  Record r;
  r.sample_rate = rate;
  r.fire_sample = static_cast<std::int64_t>(std::lround(before * rate));
  add(r, Channel::pvdf_a, 2e-3, 0.05, end, force);
  return r;
}

Gap lost(double from, double to) {
  return {static_cast<std::int64_t>(std::lround((before + from) * rate)),
          static_cast<std::int64_t>(std::lround((to - from) * rate))};
}

bool has(const ContactTrain& t, Flag f) {
  return (t.flags & f) != 0;
}

}  // namespace

TEST_CASE("lost samples that may hide an opening leave settled and bounce time unknown", "[lost]") {
  const ContactTrain whole = extract_events(record()).pvdf_a;
  REQUIRE(whole.contacts.size() == 2);
  CHECK(whole.bounce_time.value == Approx(1.9e-3).margin(5e-6));
  CHECK_FALSE(has(whole, flag_gap));
  Record r = record();
  r.gaps.push_back(lost(11.45e-3, 11.95e-3));
  const ContactTrain hidden = extract_events(r).pvdf_a;
  CHECK(has(hidden, flag_gap));
  CHECK_FALSE(hidden.settled.known());
  CHECK_FALSE(hidden.bounce_time.known());
  CHECK(hidden.contacts.front().touch.value == Approx(10e-3).margin(5e-6));
}

TEST_CASE("an edge in lost samples is as uncertain as they are long", "[lost]") {
  Record r = record();
  r.gaps.push_back(lost(11.7e-3, 12.5e-3));
  const ContactTrain t = extract_events(r).pvdf_a;
  REQUIRE(t.contacts.size() == 2);
  const Measured& touch = t.contacts.back().touch;
  CHECK(touch.u >= 0.8e-3 / std::sqrt(12.0));
  CHECK(std::abs(touch.value - 11.9e-3) < 2 * touch.u);
  CHECK(has(t, flag_gap));
  Record voltage;
  voltage.sample_rate = rate;
  voltage.fire_sample = r.fire_sample;
  add(voltage, Channel::contact_a, 1e-3, 0.01, 0.06, sense_at);
  voltage.gaps = r.gaps;
  const ContactTrain v = extract_events(voltage).contact_voltage;
  REQUIRE(v.contacts.size() == 2);
  CHECK(std::abs(v.contacts.back().touch.value - 11.9e-3) < 2 * v.contacts.back().touch.u);
}

TEST_CASE("lost samples before the first touch seen may hide an earlier one", "[lost]") {
  Record r = record();
  r.gaps.push_back(lost(9.95e-3, 11.55e-3));
  const ContactTrain t = extract_events(r).pvdf_a;
  REQUIRE(t.contacts.size() == 1);
  CHECK(std::abs(t.contacts.front().touch.value - 10e-3) < 2 * t.contacts.front().touch.u);
  CHECK(1.9e-3 < 2 * t.bounce_time.u);
  CHECK(has(t, flag_gap));
  Record early = record();  // far from the touch, or short, they hide nothing
  early.gaps.push_back(lost(1e-3, 2e-3));
  early.gaps.push_back(lost(10.7e-3, 10.71e-3));
  const ContactTrain same = extract_events(early).pvdf_a;
  CHECK(same.contacts.front().touch.u < 5e-6);
  CHECK(same.settled.known());
}

TEST_CASE("a record that ends soon after the touch has not seen it settle", "[lost]") {
  for (const double after : {20e-6, 100e-6, 300e-6, 0.75e-3, 1.4e-3}) {
    const ContactTrain t = extract_events(record(10e-3 + after)).pvdf_a;
    CAPTURE(after);
    CHECK_FALSE(t.settled.known());
    CHECK_FALSE(t.bounce_time.known());
  }
  CHECK(extract_events(record(16e-3)).pvdf_a.settled.known());
}

TEST_CASE("a core that moves at the end leaves open whether the contact has settled", "[lost]") {
  const auto travel = [](double t) { return std::clamp(0.7 * (t - 7e-3), 0.0, 6e-3); };  // at rest at 15.6 ms
  for (const bool lands : {false, true}) {
    Record r = record(lands ? 0.06 : 15.4e-3);
    add(r, Channel::laser, 1e-6, 2e-6, lands ? 0.06 : 15.4e-3, travel);
    const ContactTrain t = extract_events(r).pvdf_a;
    CHECK(t.settled.known() == lands);
    CHECK(has(t, flag_chatter) == !lands);
  }
}

TEST_CASE("a spike of one or two samples is no contact", "[lost]") {
  for (const double at : {-20e-3, 0.0, 5e-3, 11.7e-3})
    for (const int samples : {1, 2})
      for (const double newton : {5.0, 30.0, 60.0}) {
        const auto spiked = [&](double t) {
          const double since = (t - at) * rate;
          return force_at(t) + (since > -0.5 && since < samples - 0.5 ? newton : 0);
        };
        const ContactTrain t = extract_events(record(0.06, spiked)).pvdf_a;
        CAPTURE(at, samples, newton);
        REQUIRE_FALSE(t.contacts.empty());
        for (const Contact& c : t.contacts) {
          CHECK(c.touch.u < 1e-3);
          if (c.release.known()) CHECK(c.release.u < 1e-3);
        }
        CHECK(t.contacts.front().touch.value == Approx(10e-3).margin(30e-6));
        CHECK(t.contacts.back().touch.value == Approx(11.9e-3).margin(30e-6));
      }
}

TEST_CASE("a sense voltage turned round is turned back, and closures no film shows contradict", "[lost]") {
  Record r = record();
  add(r, Channel::contact_a, 1e-3, 0.01, 0.06, [](double t) { return -sense_at(t); });
  const Events turned = extract_events(r);
  REQUIRE(turned.contact_voltage.contacts.size() == 2);
  CHECK(has(turned.contact_voltage, flag_polarity));
  CHECK_FALSE(has(turned.contact_voltage, flag_contradiction));
  for (const double length : {20e-6, 50e-6, 100e-6, 300e-6}) {
    Record alone = record();
    add(alone, Channel::contact_a, 1e-3, 0.01, 0.06,
        [&](double t) { return t > 5e-3 && t < 5e-3 + length ? 0.0 : sense_at(t); });
    const Events e = extract_events(alone);
    CAPTURE(length);
    CHECK(has(e.contact_voltage, flag_contradiction));
    CHECK(has(e.pvdf_a, flag_contradiction));
  }
}

TEST_CASE("a force that rests at zero between steep flanks is open, however clean", "[lost]") {
  const auto box = [](double t, double from, double to, double newton, double flank) {
    return newton * std::clamp((t - from) / flank, 0.0, 1.0) * std::clamp((to - t) / flank, 0.0, 1.0);
  };
  for (const double open : {0.15e-3, 0.2e-3, 0.3e-3, 0.45e-3})
    for (const double flank : {5e-6, 20e-6, 50e-6})
      for (const double noise : {0.01, 0.05, 0.5}) {
        Record r;
        r.sample_rate = rate;
        r.fire_sample = static_cast<std::int64_t>(std::lround(before * rate));
        add(r, Channel::pvdf_a, 2e-3, noise, 0.06, [&](double t) {
          return box(t, 10e-3, 10.7e-3, 20, flank) + box(t, 10.7e-3 + open, 1, 15, flank);
        });
        const ContactTrain t = extract_events(r).pvdf_a;
        CAPTURE(open, flank, noise);
        REQUIRE(t.contacts.size() == 2);
        CHECK(t.contacts[1].touch.value - t.contacts[0].release.value == Approx(open).margin(30e-6));
        CHECK(t.bounce_time.u < 20e-6);
      }
}
