#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "dsp/contacts/threshold.h"
#include "dsp/events/doubt.h"
#include "dsp/events/extract.h"
#include "dsp/filter/force.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

constexpr double us = 1e-6;

double pulse(double t, double a, double b, double peak) {
  return t > a && t < b ? peak * std::sin(pi * (t - a) / (b - a)) : 0.0;
}

/// Film A closes at 12 ms with 10 N, film B at 12.4 ms with 6 N; both stay closed from 15 and 15.2 ms.
double force_a(double t) {
  return pulse(t, 12e-3, 13e-3, 10) + (t > 15e-3 ? 4 * (1 - std::exp(-(t - 15e-3) / 0.3e-3)) : 0);
}
double force_b(double t) {
  return pulse(t, 12.4e-3, 13.6e-3, 6) + (t > 15.2e-3 ? 3 * (1 - std::exp(-(t - 15.2e-3) / 0.3e-3)) : 0);
}

/// Films that show `p` and `q` of each other's force; with `turned` film A is upside down.
Record films(double p, double q, bool turned = false, double noise = 0.02) {
  bench::Random random(8);
  Record r;
  r.sample_rate = 200e3;
  r.fire_sample = 9000;
  r.conditions.hold_time = 0.05;
  for (const bool is_a : {true, false}) {
    ChannelRecord c;
    c.channel = is_a ? Channel::pvdf_a : Channel::pvdf_b;
    c.scale = is_a && turned ? -1e-3 : 1e-3;
    for (int i = 0; i < 19000; ++i) {
      const double t = r.time(static_cast<std::size_t>(i));
      const double f = is_a ? force_a(t) + p * force_b(t) : force_b(t) + q * force_a(t);
      c.raw.push_back(static_cast<std::int16_t>(std::lround((f + noise * random.normal()) / 1e-3)));
    }
    r.channels.push_back(std::move(c));
  }
  return r;
}

}  // namespace

TEST_CASE("the other film's share is taken out exactly when it is known") {
  const Record r = films(0.05, 0.03, false, 0.0);
  ExtractOptions o;
  o.crosstalk_a = 0.05;
  o.crosstalk_b = 0.03;
  const Force a = restore_force(r, Channel::pvdf_a, o, std::nullopt);
  const Force b = restore_force(r, Channel::pvdf_b, o, std::nullopt);
  double worst = 0;
  for (std::size_t i = 0; i < a.signal.size(); ++i) {
    const double t = a.signal.time(i);
    worst =
        std::max({worst, std::abs(a.signal.value[i] - force_a(t)), std::abs(b.signal.value[i] - force_b(t))});
  }
  CHECK(worst < 1.2e-3);  // half a count of either film
  CHECK(a.settled == Approx(4).margin(0.01));
  CHECK(b.settled == Approx(3).margin(0.01));
}

TEST_CASE("unmixed films touch when they touch, upside down too") {
  ExtractOptions o;
  o.crosstalk_a = o.crosstalk_b = 0.05;
  for (const bool turned : {false, true}) {
    const Events e = extract_events(films(0.05, 0.05, turned), o);
    REQUIRE(e.pvdf_a.contacts.size() == 2);
    REQUIRE(e.pvdf_b.contacts.size() == 2);
    CHECK(std::abs(e.pvdf_a.contacts[0].touch.value - 12e-3) < 5 * us);
    CHECK(std::abs(e.pvdf_b.contacts[0].touch.value - 12.4e-3) < 5 * us);
    CHECK(e.pvdf_b.contacts[0].peak.value == Approx(6).margin(0.05));
    CHECK(((e.pvdf_a.flags & flag_polarity) != 0) == turned);
  }
  const Events mixed = extract_events(films(0.05, 0.05));
  const auto& first = mixed.pvdf_b.contacts.at(0);  // sees film A's pulse 0.4 ms early, as 0.5 N
  CHECK(std::abs(first.touch.value - 12.4e-3) > 20 * us);
}

TEST_CASE("a share of the other film's noise stays in the noise; a missing film changes nothing") {
  ExtractOptions o;
  o.crosstalk_a = 0.3;
  Record r = films(0.3, 0);
  const Force a = restore_force(r, Channel::pvdf_a, o, std::nullopt);
  CHECK(a.noise == Approx(0.02 * std::hypot(1, 0.3)).epsilon(0.05));
  r.channels.pop_back();
  const Force alone = restore_force(r, Channel::pvdf_a, o, std::nullopt);
  CHECK(alone.noise == Approx(0.02).epsilon(0.05));
  o.crosstalk_a = 0.6;
  CHECK_THROWS_AS(extract_events(r, o), std::invalid_argument);
  o.crosstalk_a = -0.05;
  CHECK_NOTHROW(extract_events(r, o));
}

TEST_CASE("samples the other film lost are lost here too, once its share is taken out") {
  Record r = films(0.05, 0.05);
  r.channels[1].gaps.push_back({11500, 20});
  ExtractOptions o;
  CHECK(restore_force(r, Channel::pvdf_a, o, std::nullopt).signal.masked[11505] == mask_none);
  o.crosstalk_a = 0.05;
  CHECK(restore_force(r, Channel::pvdf_a, o, std::nullopt).signal.masked[11505] == mask_gap);
}

TEST_CASE("a record triggered by the contact has its zero before the contact") {
  for (const double trigger : {0.0, 12.5e-3, 16e-3, 30e-3}) {
    Record r = films(0, 0);
    r.fire_sample += std::llround(trigger * r.sample_rate);
    const Force a = restore_force(r, Channel::pvdf_a, {}, std::nullopt);
    INFO(trigger);
    CHECK(a.noise == Approx(0.02).epsilon(0.1));
    CHECK(std::abs(a.signal.value[4000]) < 0.1);
    CHECK((a.flags & flag_polarity) == 0);
  }
}

TEST_CASE("a record that begins at switch-on takes its beginning for zero") {
  Record r = films(0, 0);
  for (auto& c : r.channels) c.raw.erase(c.raw.begin(), c.raw.begin() + 9000);
  r.fire_sample = 0;
  const Force a = restore_force(r, Channel::pvdf_a, {}, std::nullopt);
  CHECK((a.flags & flag_no_hum_fit) != 0);
  double mean = 0;
  for (std::size_t i = 0; i < 2000; ++i) mean += a.signal.value[i] / 2000;
  CHECK(std::abs(mean) < 0.01);  // one sample alone would be off by its noise, 0.02 N
}

TEST_CASE("what a fit could not tell is admitted") {
  const Record r = films(0, 0);
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  Events e;
  e.pvdf_a.present = true;
  e.pvdf_a.resolution = 50e-6;
  e.pvdf_a.contacts = {
      {.touch = {12e-3, inf}, .release = {13e-3, 1e-6}, .peak = {10, inf}, .impulse = {1, nan}},
      {.touch = {15e-3, 1e-6}, .release = {9.0, 1e-6}, .peak = {4, 0.1}, .impulse = {}},
      {.touch = {7.0, 1e-6}, .release = {}, .peak = {}, .impulse = {}}};
  e.core.seat = {14e-3, nan};
  admit_doubt(e, r);
  REQUIRE(e.pvdf_a.contacts.size() == 2);
  CHECK(e.pvdf_a.contacts[0].touch.u == 50e-6);
  CHECK((e.pvdf_a.contacts[0].flags & flag_poor_fit) != 0);
  CHECK_FALSE(e.pvdf_a.contacts[0].peak.known());
  CHECK_FALSE(e.pvdf_a.contacts[0].impulse.known());
  CHECK_FALSE(e.pvdf_a.contacts[1].release.known());
  CHECK((e.pvdf_a.contacts[1].flags & flag_edge) != 0);
  CHECK(e.pvdf_a.contacts[1].peak.value == 4);
  CHECK(e.pvdf_a.bounce_count == 1);
  CHECK_FALSE(e.core.seat.known());
}

TEST_CASE("a gain wrong by ten is suspected from the settled forces") {
  for (const double gain : {0.1, 1.0, 10.0}) {
    Record r = films(0, 0);
    r.channels[0].scale *= gain;
    const Events e = extract_events(r);
    CHECK(((e.flags & flag_gain) != 0) == (gain != 1.0));
  }
  Record milli = films(0, 0);
  milli.channels.pop_back();
  milli.channels[0].scale *= 1e-3;  // alone, but no contact settles at 4 mN
  const Events e = extract_events(milli);
  CHECK((e.pvdf_a.flags & flag_gain) != 0);
}

TEST_CASE("a laboratory's level: times where the force crosses a share of the settled force") {
  const Record r = films(0, 0, false, 0.005);
  const Force a = restore_force(r, Channel::pvdf_a, {}, std::nullopt);
  for (const double share : {0.1, 0.5}) {
    const ContactTrain t = threshold_train(a.signal, a.settled, a.noise, 0.05, {share, 0, 0});
    REQUIRE(t.contacts.size() == 2);
    const double level = share * 4,
                 across = std::asin(level / 10) / pi * 1e-3;  // into a half sine of 1 ms and 10 N
    CHECK(std::abs(t.contacts[0].touch.value - 12e-3 - across) < 2 * us);
    CHECK(std::abs(t.contacts[0].release.value - 13e-3 + across) < 2 * us);
    CHECK(std::abs(t.contacts[1].touch.value - 15e-3 + 0.3e-3 * std::log(1 - share)) < 3 * us);
    CHECK_FALSE(t.contacts[1].release.known());
    CHECK(t.bounce_count == 1);
    CHECK(t.contacts[0].peak.value == Approx(10).margin(0.05));
    CHECK(t.contacts[0].impulse.value == Approx(10e-3 * 2 / pi * std::cos(pi * across / 1e-3)).epsilon(0.01));
  }
  CHECK(threshold_train(a.signal, a.settled, a.noise, 0.05, {0.1, 2.5e-3, 0}).contacts.size() == 1);
  CHECK(threshold_train(a.signal, a.settled, a.noise, 0.05, {0.1, 0, 1.5e-3}).contacts.size() == 1);
  const ContactTrain none = threshold_train(a.signal, 0.0, a.noise, 0.05, {});
  CHECK(none.contacts.empty());
  CHECK((none.flags & flag_poor_fit) != 0);
  CHECK_FALSE(threshold_train({}, 4, 0.1, 0.05, {}).present);
  CHECK_THROWS_AS(threshold_train(a.signal, 4, 0.1, 0.05, {1.0, 0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(threshold_train(a.signal, 4, 0.1, 0.05, {0.1, -1, 0}), std::invalid_argument);
}
