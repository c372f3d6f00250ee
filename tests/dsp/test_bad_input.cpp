#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "dsp/events/coil.h"
#include "dsp/events/extract.h"
#include "dsp/events/prepare.h"

using namespace powbench;
using namespace powbench::dsp;

namespace {

/// Every number is either finite with a non-negative uncertainty, or openly unknown.
void check_sane(const Events& e) {
  const auto sane = [](const Measured& m) {
    CHECK((!m.known() || (std::isfinite(m.u) && m.u >= 0) || std::isnan(m.u)));
  };
  for (const ContactTrain* t : {&e.pvdf_a, &e.pvdf_b, &e.contact_voltage}) {
    for (const Contact& c : t->contacts)
      for (const Measured& m : {c.touch, c.release, c.peak, c.impulse}) sane(m);
    sane(t->settled);
    sane(t->bounce_time);
    CHECK(t->bounce_count >= 0);
    CHECK(std::isfinite(t->noise));
    for (std::size_t i = 1; i < t->contacts.size(); ++i) {
      const Contact &before = t->contacts[i - 1], &now = t->contacts[i];
      CHECK(before.release.known());
      CHECK(now.touch.value > before.release.value - 50e-6);
    }
  }
  for (const Measured& m :
       {e.core.seat, e.core.settled, e.core.impact_velocity, e.core.travel, e.coil.closing_angle,
        e.coil.switch_on, e.coil.mains_hertz, e.coil.supply_volts, e.coil.peak_current})
    sane(m);
}

Record with_all_channels(std::size_t n, std::int16_t level) {
  Record r;
  r.sample_rate = 1e5;
  r.fire_sample = static_cast<std::int64_t>(n / 3);
  for (std::size_t c = 0; c < channel_count; ++c) {
    ChannelRecord ch;
    ch.channel = static_cast<Channel>(c);
    ch.scale = 1e-3;
    ch.corner_hertz = 0.5;
    ch.raw.assign(n, level);
    r.channels.push_back(ch);
  }
  return r;
}

}  // namespace

TEST_CASE("empty records") {
  const Events e = extract_events(Record{});
  check_sane(e);
  CHECK_FALSE(e.pvdf_a.present);
  CHECK_FALSE(e.core.present);
  CHECK_FALSE(e.coil.closing_angle.known());
  CHECK((e.flags & flag_no_calibration) != 0);
  CHECK(prepare(Record{}).pvdf_a.empty());
}

TEST_CASE("records of no to a few samples, and constant ones") {
  for (const std::size_t n : {0, 1, 2, 3, 7, 8, 20, 27, 60, 500, 14000})
    for (const std::int16_t level :
         {std::int16_t{0}, std::int16_t{1234}, std::int16_t{32767}, std::int16_t{-32768}}) {
      const Record r = with_all_channels(n, level);
      const Events e = extract_events(r);
      check_sane(e);
      CHECK(e.pvdf_a.contacts.empty());
      CHECK_FALSE(e.pvdf_a.present);  // a constant channel is dead
      CHECK_FALSE(e.core.seat.known());
      CHECK_FALSE(e.coil.closing_angle.known());
      CHECK_NOTHROW(prepare(r));
    }
}

TEST_CASE("each channel missing in turn") {
  const Record whole = bench::synthesise_full(1e5, 50, 1.0, 3);
  for (std::size_t c = 0; c < channel_count; ++c) {
    Record r = whole;
    std::erase_if(r.channels, [&](const ChannelRecord& ch) { return index(ch.channel) == c; });
    const Events e = extract_events(r);
    check_sane(e);
    const auto gone = static_cast<Channel>(c);
    CHECK(e.pvdf_a.present == (gone != Channel::pvdf_a));
    CHECK(e.pvdf_b.present == (gone != Channel::pvdf_b));
    CHECK(e.contact_voltage.present == (gone != Channel::contact_a));
    CHECK(e.core.present == (gone != Channel::laser));
    CHECK(e.coil.closing_angle.known() == (gone != Channel::coil_voltage));
    CHECK(angle_by_coil(e.coil) == (gone == Channel::mains_voltage));
    if (e.coil.closing_angle.known()) CHECK(e.coil.closing_angle.value == Approx(1.0).margin(0.01));
    CHECK(e.coil.supply_volts.known() == (gone != Channel::mains_voltage));
    CHECK(e.coil.peak_current.known() == (gone != Channel::coil_current));
    CHECK_NOTHROW(prepare(r));
  }
}

TEST_CASE("pre-trigger absent, too short, or all of the record") {
  const Record whole = bench::synthesise_full(1e5, 50, 1.0, 4);
  for (const std::int64_t fire : {-100, 0, 1, 10, 1900, 13999, 14000, 100000}) {
    Record r = whole;
    r.fire_sample = fire;
    const Events e = extract_events(r);
    check_sane(e);
    if (fire < 3900) {
      CHECK_FALSE(e.coil.closing_angle.known());
      CHECK((e.pvdf_a.flags & flag_no_hum_fit) != 0);
    }
  }
}

TEST_CASE("records that cannot mean anything are refused with the reason") {
  Record r = with_all_channels(100, 1);
  r.sample_rate = 0;
  CHECK_THROWS_AS(extract_events(r), std::invalid_argument);
  r.sample_rate = std::nan("");
  CHECK_THROWS_AS(extract_events(r), std::invalid_argument);
  r = with_all_channels(100, 1);
  r.channels[0].scale = 0;
  CHECK_THROWS_AS(extract_events(r), std::invalid_argument);
  r.channels[0].scale = INFINITY;
  CHECK_THROWS_AS(extract_events(r), std::invalid_argument);
  ExtractOptions o;
  o.touch_sigmas = -1;
  CHECK_THROWS_AS(extract_events(Record{}, o), std::invalid_argument);
}

TEST_CASE("all samples lost") {
  Record r = bench::synthesise_full(1e5, 50, 1.0, 5);
  r.gaps.push_back({0, 1 << 30});
  const Events e = extract_events(r);
  check_sane(e);
  CHECK(e.pvdf_a.contacts.empty());
}

TEST_CASE("random counts never crash and never give a silent number") {
  bench::Random random(77);
  for (int k = 0; k < 12; ++k) {
    Record r = with_all_channels(3000 + static_cast<std::size_t>(k) * 300, 0);
    r.fire_sample = k % 2 ? 2000 : 300;
    const double swing = k % 3 == 0 ? 30000 : (k % 3 == 1 ? 40 : 2);
    for (auto& c : r.channels) {
      double walk = 0;
      for (auto& v : c.raw) {
        walk = 0.98 * walk + random.uniform(-swing, swing);
        v = static_cast<std::int16_t>(
            std::clamp(k % 2 ? walk : random.uniform(-swing, swing), -32768.0, 32767.0));
      }
    }
    check_sane(extract_events(r));
    CHECK_NOTHROW(prepare(r));
  }
}
