#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "bench/dsp_synth.h"
#include "dsp/contacts/contact_train.h"
#include "dsp/events/extract.h"
#include "dsp/filter/force.h"
#include "dsp/filter/sos.h"

using namespace powbench;
using namespace powbench::dsp;
using powbench::bench::Random;

namespace {

/// A film record at 100 kS/s with `force(t)`, noise 0.03 N, optionally limited.
Record film(auto&& force, double noise = 0.03, double clip = 1e9, double corner = 0.0, double rate = 1e5) {
  Random random(11);
  Record r;
  r.sample_rate = rate;
  r.fire_sample = std::llround(0.04 * rate);
  ChannelRecord c;
  c.channel = Channel::pvdf_a;
  c.scale = 8e-3;
  c.corner_hertz = corner;
  const double top = std::min(clip / c.scale, 32767.0);
  c.clip_high = static_cast<std::int16_t>(top);
  for (std::size_t i = 0; i < static_cast<std::size_t>(0.1 * rate); ++i) {
    const double x = force(static_cast<double>(i) / rate - 0.04) + noise * random.normal();
    c.raw.push_back(static_cast<std::int16_t>(std::lround(std::min(x / c.scale, top))));
  }
  r.channels.push_back(std::move(c));
  return r;
}

double half_sine(double t, double a, double b, double f) {
  return t > a && t < b ? f * std::sin(pi * (t - a) / (b - a)) : 0.0;
}

ContactTrain train_of(const Record& r) {
  return extract_events(r).pvdf_a;
}

}  // namespace

TEST_CASE("hard contacts of 0.1 ms at 100 kS/s: found, timed within their uncertainty") {
  double z2 = 0;
  int n = 0;
  for (int k = 0; k < 40; ++k) {
    const double a = 0.0100013 + k * 0.37e-6 + 1e-6 * (k % 7), b = a + 0.1e-3, c = b + 0.5e-3;
    const auto t = train_of(film([&](double x) {
      return half_sine(x, a, b, 80) + half_sine(x, c, c + 0.1e-3, 40) +
             (x > c + 1e-3 ? 3 * (1 - std::exp(-(x - c - 1e-3) / 1e-4)) : 0.0);
    }));
    REQUIRE(t.contacts.size() == 3);
    CHECK(t.contacts[0].peak.value == Approx(80).epsilon(0.02));
    CHECK(std::abs(t.contacts[0].touch.value - a) < 3e-6);
    CHECK(std::abs(t.contacts[1].release.value - c - 0.1e-3) < 3e-6);
    CHECK(t.contacts[0].impulse.value == Approx(80 * 0.1e-3 * 2 / pi).epsilon(0.02));
    for (const auto& [m, truth] : {std::pair(t.contacts[0].touch, a), std::pair(t.contacts[0].release, b)})
      z2 += std::pow((m.value - truth) / m.u, 2), ++n;
    CHECK(t.bounce_count == 2);
    CHECK(t.settled.value == Approx(c + 1e-3).margin(15e-6));
    CHECK(t.bounce_time.value == Approx(t.settled.value - t.contacts[0].touch.value));
    CHECK_FALSE(t.contacts.back().release.known());
  }
  CHECK(std::sqrt(z2 / n) < 1.25);
}

TEST_CASE("AC pulsation of the settled force is no bounce") {
  const auto t = train_of(film([](double x) {
    return x > 0.012 ? 3 * (1 - std::exp(-(x - 0.012) / 2e-4)) * (1 + 0.6 * std::sin(2 * pi * 100 * x)) : 0.0;
  }));
  REQUIRE(t.contacts.size() == 1);
  CHECK(t.bounce_count == 0);
  CHECK(t.bounce_time.value == 0.0);
  CHECK(t.settled.value == Approx(0.012).margin(20e-6));
  CHECK(t.settled_force.value == Approx(3).epsilon(0.15));
}

TEST_CASE("undershoot after a release is neither contact nor polarity") {
  const auto t = train_of(film([](double x) {
    const double under = x > 0.0105 ? -2.0 * std::exp(-(x - 0.0105) / 3e-4) : 0.0;
    return half_sine(x, 0.010, 0.0105, 30) + (x < 0.013 ? under : 0.0) +
           (x > 0.013 ? 3.0 * (1 - std::exp(-(x - 0.013) / 1e-4)) : 0.0);
  }));
  REQUIRE(t.contacts.size() == 2);
  CHECK((t.flags & flag_polarity) == 0);
}

TEST_CASE("clipping at half the peak: the fit restores the peak and says so") {
  const auto t = train_of(film(
      [](double x) {
        return half_sine(x, 0.010, 0.011, 10) + (x > 0.013 ? 3.0 * (1 - std::exp(-(x - 0.013) / 1e-4)) : 0.0);
      },
      0.03, 5.0));
  REQUIRE(t.contacts.size() == 2);
  CHECK(t.contacts[0].peak.value == Approx(10).epsilon(0.06));
  CHECK((t.contacts[0].flags & flag_clipped) != 0);
  CHECK(t.contacts[0].touch.value == Approx(0.010).margin(4e-6));
}

TEST_CASE("clipping at half the peak: over many records the restored peak is the true one") {
  for (const double rate : {1e5, 1e6}) {
    double sum = 0, squares = 0, worst = 0;
    const int n = rate < 5e5 ? 60 : 20;
    for (int k = 0; k < n; ++k) {
      const double a = 0.010 + k * 13.7e-6;
      const auto t = train_of(film(
          [&](double x) {
            return half_sine(x, a, a + 1e-3, 10) +
                   (x > a + 3e-3 ? 3.0 * (1 - std::exp(-(x - a - 3e-3) / 1e-4)) : 0.0);
          },
          0.03, 5.0, 0.0, rate));
      REQUIRE(t.contacts.size() == 2);
      const double ratio = t.contacts[0].peak.value / 10;
      CHECK((t.contacts[0].flags & flag_clipped) != 0);
      sum += ratio, squares += ratio * ratio, worst = std::max(worst, std::abs(ratio - 1));
    }
    // 0.9994 +- 0.0012 at 100 kS/s, 0.9993 +- 0.0006 at 1 MS/s
    CHECK(sum / n == Approx(0.999).margin(0.002));
    CHECK(std::sqrt(squares / n - sum * sum / n / n) < 4e-3 * std::sqrt(1e6 / rate));
    CHECK(worst < 0.01 * std::sqrt(1e6 / rate));
  }
}

TEST_CASE("lost samples: the event that touches them is flagged, the others are not") {
  Record r = film([](double x) {
    return half_sine(x, 0.010, 0.0105, 20) + half_sine(x, 0.012, 0.0125, 10) +
           (x > 0.014 ? 3.0 * (1 - std::exp(-(x - 0.014) / 1e-4)) : 0.0);
  });
  r.gaps.push_back({5020, 6});
  for (std::size_t i = 5020; i < 5026; ++i) r.channels[0].raw[i] = -32000;  // whatever the rig filled in
  const auto t = train_of(r);
  REQUIRE(t.contacts.size() == 3);
  CHECK((t.contacts[0].flags & flag_gap) != 0);
  CHECK((t.contacts[1].flags & flag_gap) == 0);
  CHECK((t.flags & flag_gap) != 0);
  CHECK(t.contacts[0].touch.value == Approx(0.010).margin(6e-6));
}

TEST_CASE("a contact that never settles ends open, one that closes at the end stays open-ended") {
  const auto bouncing = train_of(
      film([](double x) { return half_sine(x, 0.010, 0.0105, 20) + half_sine(x, 0.050, 0.0505, 10); }));
  REQUIRE(bouncing.contacts.size() == 2);
  CHECK_FALSE(bouncing.settled.known());
  CHECK_FALSE(bouncing.bounce_time.known());
  CHECK(bouncing.contacts.back().release.known());
  CHECK_FALSE(bouncing.settled_force.known());
  const auto late = train_of(film([](double x) { return x > 0.0595 ? 5.0 : 0.0; }));
  for (const auto& c : late.contacts) CHECK(std::isfinite(c.touch.value));
}

TEST_CASE("no contact at all: an empty train, nothing invented in noise") {
  for (const double noise : {0.004, 0.03, 1.0}) {
    const auto t = train_of(film([](double) { return 0.0; }, noise));
    CHECK(t.present);
    CHECK(t.contacts.empty());
    CHECK_FALSE(t.settled.known());
    CHECK(t.bounce_count == 0);
    CHECK(t.noise == Approx(std::hypot(noise, 8e-3 / std::sqrt(12.0))).epsilon(0.15));
  }
}

TEST_CASE("resolution is reported and openings above it are seen") {
  for (const double gap : {0.08e-3, 0.12e-3, 0.2e-3}) {
    const auto t = train_of(film([&](double x) {
      return half_sine(x, 0.010, 0.0105, 10) + half_sine(x, 0.0105 + gap, 0.011 + gap, 5) +
             (x > 0.013 ? 3.0 * (1 - std::exp(-(x - 0.013) / 1e-4)) : 0.0);
    }));
    CHECK(t.resolution <= 0.08e-3);
    CHECK(t.contacts.size() == 3);
  }
}

TEST_CASE("openings are merged only on request") {
  const Record r = film([](double x) {
    return half_sine(x, 0.010, 0.0105, 20) + half_sine(x, 0.0107, 0.0112, 10) +
           (x > 0.0132 ? 3.0 * (1 - std::exp(-(x - 0.0132) / 1e-4)) : 0.0);
  });
  ExtractOptions o;
  CHECK(extract_events(r, o).pvdf_a.bounce_count == 2);
  o.merge_openings = 1e-3;
  const auto merged = extract_events(r, o).pvdf_a;
  CHECK(merged.bounce_count == 1);
  CHECK(merged.contacts[0].release.value == Approx(0.0112).margin(10e-6));
  CHECK(merged.contacts[0].peak.value == Approx(20).epsilon(0.03));
}

TEST_CASE(
    "equal record, equal events, bit for bit; also where the films go side by side or the other way round") {
  const Record r = bench::synthesise_full(1e5, 50, 1.0, 2);
  const Events a = extract_events(r);
  REQUIRE(a.pvdf_b.contacts.size() > 1);
  using Work = std::function<void()>;
  const RunBoth ways[] = {in_turn, [](const Work& x, const Work& y) { y(), x(); },
                          [](const Work& x, const Work& y) {
                            std::thread beside(x);
                            y();
                            beside.join();
                          }};
  for (const RunBoth& way : ways) {
    const Events b = extract_events(r, {}, way);
    for (const auto film : {&Events::pvdf_a, &Events::pvdf_b}) {
      REQUIRE((a.*film).contacts.size() == (b.*film).contacts.size());
      for (std::size_t i = 0; i < (a.*film).contacts.size(); ++i) {
        CHECK((a.*film).contacts[i].touch.value == (b.*film).contacts[i].touch.value);
        CHECK((a.*film).contacts[i].touch.u == (b.*film).contacts[i].touch.u);
      }
    }
    CHECK(a.core.seat.value == b.core.seat.value);
    CHECK(a.coil.closing_angle.value == b.coil.closing_angle.value);
  }
}

TEST_CASE("sampling rate changes the uncertainty, not the answer") {
  bench::SynthSettings s;
  for (const double rate : {1e5, 2e5, 1e6}) {
    s.rate = rate;
    const auto r = bench::synthesise(s, 5);
    const auto t = train_of(r.record);
    REQUIRE(t.contacts.size() == r.contacts.size());
    for (std::size_t i = 0; i < t.contacts.size(); ++i)
      CHECK(std::abs(t.contacts[i].touch.value - r.contacts[i].touch) < 5 * t.contacts[i].touch.u);
  }
}

TEST_CASE(
    "a low-pass hides what the fit resolves: a pulse of 0.2 ms loses half its peak at 2 kHz, none at 10 "
    "kHz") {
  Signal s;
  s.dt = 1e-6;
  s.t0 = -0.02;
  for (int i = 0; i < 40000; ++i) s.value.push_back(half_sine(s.t0 + i * s.dt, 0.0, 0.2e-3, 10.0));
  s.masked.assign(s.value.size(), mask_none);
  for (const auto& [hertz, share] : {std::pair(2e3, 0.49), std::pair(4e3, 0.83), std::pair(10e3, 1.01)}) {
    const auto y =
        filter_zero_phase(to_sections({FilterKind::low, 4, 0, hertz, s.rate(), false}), s).signal.value;
    CHECK(*std::max_element(y.begin(), y.end()) == Approx(10 * share).epsilon(0.06));
  }
}

TEST_CASE("no contact at the first or the last samples, whatever the noise") {
  for (const double snr : {20.0, 30.0})
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      bench::SynthSettings settings;
      settings.snr_db = snr;
      settings.rate = 2e5;
      const auto r = bench::synthesise(settings, seed);
      const auto t = train_of(r.record);
      REQUIRE_FALSE(t.contacts.empty());
      CHECK(t.contacts.front().touch.value > r.contacts.front().touch - 0.3e-3);
      CHECK(t.contacts.back().touch.value < r.contacts.back().touch + 0.3e-3);
      CHECK_FALSE(t.contacts.back().release.known());
    }
}

TEST_CASE("one dead film: its quality gate says so, the other is analysed alone") {
  Record r = bench::synthesise_full(1e5, 50, 1.0, 6);
  for (auto& c : r.channels)
    if (c.channel == Channel::pvdf_b) std::fill(c.raw.begin(), c.raw.end(), std::int16_t{12});
  const Events e = extract_events(r);
  CHECK(e.pvdf_a.present);
  CHECK_FALSE(e.pvdf_b.present);
  CHECK(e.pvdf_a.contacts.size() == 6);
  CHECK_FALSE(e.pole.by_force.present);
  CHECK_FALSE(e.pole.disagreement.known());
}

TEST_CASE(
    "two trains of a whole record: apart at the core's seat, force and voltage agree within the openings' "
    "edges") {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    bench::FullTruth truth;
    const Events e = extract_events(bench::synthesise_full(1e5, 50, 1.0, seed, &truth));
    for (const ContactTrain* t : {&e.pvdf_a, &e.pvdf_b, &e.contact_voltage, &e.pole.by_force}) {
      CHECK(t->first_train.openings == 2);
      CHECK(t->second_train.openings == 3);
      CHECK(t->second_train.from.value == Approx(truth.core_seat + 0.05e-3).margin(40e-6));
    }
    CHECK(e.pole.longest_disagreement.value < 60e-6);
  }
}

TEST_CASE("a film of the whole record ten times too strong or too weak is suspected, and no other") {
  for (const double gain : {0.1, 1.0, 10.0}) {
    Record r = bench::synthesise_full(1e5, 50, 1.0, 3);
    for (auto& c : r.channels)
      if (c.channel == Channel::pvdf_b) c.scale *= gain;
    const Events e = extract_events(r);
    CHECK(((e.flags & flag_gain) != 0) == (gain != 1.0));
    for (const ContactTrain* t : {&e.pvdf_a, &e.pvdf_b})
      CHECK(((t->flags & flag_gain) != 0) == (gain != 1.0));
    CHECK((e.contact_voltage.flags & flag_gain) == 0);
    CHECK(e.pvdf_b.contacts.size() == 6);  // times do not depend on the gain
  }
}

TEST_CASE(
    "films at 1 MS/s beside a laser of 20 kS/s: its averaging and holding is a delay, the films do not feel "
    "it") {
  const double rate = 1e6;
  const std::size_t held = 50;  // samples of the record in one of the laser
  double worst = 0, z2 = 0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    for (const std::size_t phase : {std::size_t{0}, std::size_t{17}}) {
      bench::FullTruth truth;
      Record r = bench::synthesise_full(rate, 50, 1.0, seed, &truth);
      std::erase_if(r.channels,
                    [](const auto& c) { return c.channel == Channel::aux; });  // would time the seat
      const Events fast = extract_events(r);
      for (auto& c : r.channels) {
        if (c.channel != Channel::laser) continue;
        auto slow = c.raw;
        for (std::size_t i = phase; i + held <= slow.size(); i += held) {
          double mean = 0;  // of the window before, shown until the next one is complete
          for (std::size_t k = 0; k < held; ++k) mean += i >= held ? c.raw[i - held + k] : c.raw[i];
          for (std::size_t k = 0; k < held; ++k)
            slow[i + k] = static_cast<std::int16_t>(std::lround(mean / static_cast<double>(held)));
        }
        c.raw = std::move(slow);
        c.delay = 50e-6;  // half a window of averaging, half a window of holding
      }
      const Events e = extract_events(r);
      const double off = e.core.seat.value - truth.core_seat;
      CHECK(e.core.impact_velocity.value == Approx(truth.impact_velocity).margin(0.06));
      REQUIRE(e.pvdf_a.contacts.size() == 6);
      REQUIRE(fast.pvdf_a.contacts.size() == 6);
      for (std::size_t q = 0; q < 6; ++q)
        CHECK(std::abs(fast.pvdf_a.contacts[q].touch.value - e.pvdf_a.contacts[q].touch.value) < 0.5e-6);
      worst = std::max(worst, std::abs(off)), z2 += off * off / e.core.seat.u / e.core.seat.u, ++n;
    }
  CHECK(worst < 50e-6);  // one sample of the laser
  CHECK(std::sqrt(z2 / n) < 1.25);
}

TEST_CASE("a blow that rises slowly dates the core's seat late, and its uncertainty says so") {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    bench::FullTruth truth;
    const Events e = extract_events(bench::synthesise_full(1e6, 50, 1.0, seed, &truth));
    CHECK(e.core.seat.u < 20e-6);
    CHECK(std::abs(e.core.seat.value - truth.core_seat) < 2 * e.core.seat.u);
  }
}

TEST_CASE("two clocks 50 ppm apart: 5 us over 100 ms, a scale of time and not of index") {
  Record r = film([](double x) {
    return half_sine(x, 0.010, 0.0105, 20) + half_sine(x, 0.050, 0.0505, 20) +
           (x > 0.055 ? 3.0 * (1 - std::exp(-(x - 0.055) / 1e-4)) : 0.0);
  });
  const auto own = train_of(r);
  r.sample_rate *= 1 + 50e-6;
  const auto other = train_of(r);
  REQUIRE(own.contacts.size() == 3);
  REQUIRE(other.contacts.size() == 3);
  for (std::size_t q = 0; q < 3; ++q) {
    const double t = own.contacts[q].touch.value;
    CHECK(t - other.contacts[q].touch.value == Approx(50e-6 * t).margin(0.2e-6));
  }
}
