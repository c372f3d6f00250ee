#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "core/phase.h"
#include "dsp/events/coil.h"
#include "dsp/events/extract.h"
#include "rigs/simulated_record.h"

using namespace powbench;
using namespace powbench::dsp;

TEST_CASE("closing angle within 0.1 degrees rms at 50 Hz +- 0.5, its uncertainty calibrated") {
  for (const double hertz : {49.5, 50.0, 50.5}) {
    double e2 = 0, z2 = 0;
    const int n = 40;
    for (int k = 0; k < n; ++k) {
      bench::FullTruth truth;
      const Record r =
          bench::synthesise_full(1e5, hertz, radians(9.0 * k), static_cast<std::uint64_t>(k), &truth);
      ExtractOptions o;
      o.ring_modes = 0;
      const CoilEvents c = extract_events(r, o).coil;
      REQUIRE(c.closing_angle.known());
      const double d = wrap_half_turn(c.closing_angle.value - truth.closing_angle);
      e2 += d * d / n;
      z2 += d * d / (c.closing_angle.u * c.closing_angle.u) / n;
      CHECK(std::abs(c.mains_hertz.value - hertz) < 5 * c.mains_hertz.u);
      CHECK(c.supply_volts.value == Approx(325 / std::sqrt(2.0)).epsilon(0.002));
      CHECK(std::abs(c.switch_on.value) < 10e-6);
    }
    CHECK(degrees(std::sqrt(e2)) < 0.1);
    CHECK(std::sqrt(z2) < 1.6);
  }
}

namespace {

Record without_mains(Record r) {
  std::erase_if(r.channels, [](const ChannelRecord& c) { return c.channel == Channel::mains_voltage; });
  return r;
}

/// The coil voltage as `f` makes it of what it was, V.
Record with_coil(Record r, double (*f)(double volts, double t)) {
  for (auto& c : r.channels)
    if (c.channel == Channel::coil_voltage)
      for (std::size_t i = 0; i < c.raw.size(); ++i)
        c.raw[i] = static_cast<std::int16_t>(std::lround(f(c.value(i), r.time(i)) / c.scale - c.offset));
  return r;
}

}  // namespace

TEST_CASE("closing angle from the coil voltage alone, its uncertainty calibrated") {
  for (const double hertz : {49.5, 50.0, 50.5}) {
    double e2 = 0, z2 = 0;
    const int n = 40;
    for (int k = 0; k < n; ++k) {
      bench::FullTruth truth;
      const Record r = without_mains(
          bench::synthesise_full(1e5, hertz, radians(9.0 * k), static_cast<std::uint64_t>(k), &truth));
      const CoilEvents c = coil_events(r, std::nullopt, {});
      INFO(hertz << " Hz, " << 9.0 * k << " deg: " << c.no_angle);
      REQUIRE(c.closing_angle.known());
      CHECK(angle_by_coil(c));
      const double d = wrap_half_turn(c.closing_angle.value - truth.closing_angle);
      e2 += d * d / n;
      z2 += d * d / (c.closing_angle.u * c.closing_angle.u) / n;
    }
    INFO(hertz << " Hz: " << degrees(std::sqrt(e2)) << " deg rms, z " << std::sqrt(z2));
    CHECK(degrees(std::sqrt(e2)) < 0.2);
    CHECK(std::sqrt(z2) < 1.6);
  }
}

TEST_CASE(
    "closing angle from the coil voltage of the simulated rig, stiff and weak source, off within the "
    "record") {
  double worst = 0, z2 = 0;
  int n = 0;
  for (const double ohms : {0.0, 5.0, 20.0})
    for (int k = 0; k < 8; ++k) {
      Conditions c;
      c.closing_angle = radians(45.0 * k + 5);
      c.hold_time = 0.1;
      rigs::SimRigConfig rig;
      rig.record_length = k % 2 ? 0.2 : 0.13;
      rig.supply.mains.resistance = ohms;
      Record r = without_mains(rigs::simulate_record({}, c, rig).record);
      r.conditions.hold_time = std::nan("");
      const CoilEvents e = coil_events(r, std::nullopt, {});
      INFO(ohms << " ohm, " << 45.0 * k + 5 << " deg: " << e.no_angle);
      REQUIRE(e.closing_angle.known());
      const double d = wrap_half_turn(e.closing_angle.value - c.closing_angle);
      INFO(degrees(d) << " +- " << degrees(e.closing_angle.u));
      CHECK(std::abs(degrees(d)) < 1.0);
      worst = std::max(worst, std::abs(d)), z2 += d * d / (e.closing_angle.u * e.closing_angle.u), ++n;
    }
  INFO("worst " << degrees(worst) << " deg, z " << std::sqrt(z2 / n));
  CHECK(std::sqrt(z2 / n) < 1.6);
}

TEST_CASE("a coil voltage that is no plain sine gives no closing angle") {
  const Record r = without_mains(bench::synthesise_full(1e5, 50, 1, 1));
  REQUIRE(coil_events(r, std::nullopt, {}).closing_angle.known());
  for (const auto f : {+[](double v, double) { return std::abs(v); },                  // full bridge
                       +[](double v, double) { return std::max(v, 0.0); },             // half wave
                       +[](double, double t) { return t < 0 ? 0.0 : 24.0; },           // DC
                       +[](double v, double) { return std::abs(v) < 200 ? 0.0 : v; },  // phase control
                       +[](double v, double t) { return t < 30e-3 ? v : -v; },      // another phase at first
                       +[](double v, double t) { return t < 40e-3 ? v : 0.0; }}) {  // over too soon
    const CoilEvents e = coil_events(with_coil(r, f), std::nullopt, {});
    CHECK_FALSE(e.closing_angle.known());
    CHECK(e.no_angle == "no mains-voltage channel, and the coil voltage shows no plain sine behind a step");
  }
}

TEST_CASE("a shot at the wrong angle is flagged") {
  Record r = bench::synthesise_full(1e5, 50, radians(60), 1);
  Events e = extract_events(r);
  const auto off = [&](double tolerance) {
    check_angle(e, r.conditions, tolerance);
    CHECK((e.flags & flag_angle_off) == (e.coil.flags & flag_angle_off));
    return (e.flags & flag_angle_off) != 0;
  };
  CHECK_FALSE(off(radians(1)));
  r.conditions.closing_angle = radians(62);
  CHECK(off(radians(1)));
  CHECK_FALSE(off(radians(5)));
  CHECK_FALSE(off(0));  // none given
  r.conditions.closing_angle = radians(240);
  r.conditions.polarity = -1;
  CHECK_FALSE(off(radians(1)));
  r.conditions.closing_angle = std::nan("");  // nothing was commanded
  CHECK_FALSE(off(radians(1)));
  r.conditions.closing_angle = 0;
  e.coil.closing_angle = {};
  CHECK_FALSE(off(radians(1)));
}

TEST_CASE("core seat from the kink of the travel, on a base that goes on moving") {
  double e2 = 0;
  const int n = 20;
  for (int k = 0; k < n; ++k) {
    bench::FullTruth truth;
    const Record r = bench::synthesise_full(1e5, 50, 0.3 * k, static_cast<std::uint64_t>(k), &truth);
    const CoreEvents c = extract_events(r).core;
    REQUIRE(c.seat.known());
    e2 += std::pow(c.seat.value - truth.core_seat, 2) / n;
    CHECK(c.impact_velocity.value == Approx(truth.impact_velocity).epsilon(0.03));
    CHECK(c.bounce_time.value == 0.0);
    CHECK(c.travel.value == Approx(3.8e-3).epsilon(0.01));
  }
  CHECK(std::sqrt(e2) < 15e-6);
}

TEST_CASE("a core that turns back has no seat, one that arrives late has") {
  sim::Specimen stiff;
  stiff.core.return_preload = 15;
  stiff.core.return_rate = 3800;
  for (const double volts : {195.0, 200.0, 220.0})
    for (const double angle : {60.0, 150.0}) {
      CAPTURE(volts, angle);
      Conditions c;
      c.supply_volts = volts;
      c.closing_angle = radians(angle);
      const Events e = extract_events(rigs::simulate_record(stiff, c, {}).record);
      const bool closes = volts > 210;
      CHECK(e.contact_voltage.contacts.empty() != closes);
      CHECK(e.core.seat.known() == closes);
      CHECK(e.core.settled.known() == closes);
      CHECK(e.core.travel.known());  // 0.2 mm, or all of it
    }
}

TEST_CASE("a core that never moves has no seat") {
  Record r = bench::synthesise_full(1e5, 50, 1, 1);
  bench::Random random(2);
  for (auto& c : r.channels)
    if (c.channel == Channel::laser)
      for (auto& v : c.raw) v = static_cast<std::int16_t>(std::lround(3 * random.normal()));
  const CoreEvents c = extract_events(r).core;
  CHECK(c.present);
  CHECK_FALSE(c.seat.known());
  CHECK(c.travel.value == Approx(0.0).margin(2e-6));
}

namespace {

/// Mains of 325 V and the coil behind a switch that closes at the time 0, both with noise; `mains` and `coil` say what
/// the channels show.
Record coil_record(double angle_deg, double noise, double (*mains)(double phase),
                   double (*coil)(double phase), std::uint64_t seed) {
  bench::Random random(seed);
  Record r;
  r.sample_rate = 1e5;
  r.fire_sample = 4000;
  for (const Channel channel : {Channel::mains_voltage, Channel::coil_voltage}) {
    ChannelRecord c;
    c.channel = channel;
    c.scale = 0.02;
    for (int i = 0; i < 10000; ++i) {
      const double t = (i - 4000) / r.sample_rate, phase = 2 * pi * 50 * t + radians(angle_deg);
      const double v = channel == Channel::mains_voltage ? mains(phase) : t < 0 ? 0.0 : coil(phase);
      c.raw.push_back(static_cast<std::int16_t>(std::lround((v + noise * random.normal()) / c.scale)));
    }
    r.channels.push_back(std::move(c));
  }
  return r;
}

double plain(double phase) {
  return 325 * std::sin(phase);
}

}  // namespace

TEST_CASE(
    "closing angle beside a zero of the mains, under noise, a zero off and even harmonics: within 3 u") {
  struct Mains {
    double (*channel)(double), (*coil)(double);
  };
  const Mains all[] = {{plain, plain},
                       {[](double p) { return plain(p) + 8; }, plain},
                       {[](double p) { return plain(p) + 6.5 * std::sin(2 * p + 1); },
                        [](double p) { return plain(p) + 6.5 * std::sin(2 * p + 1); }}};
  for (const Mains& m : all)
    for (const double noise : {0.15, 2.0, 5.0})
      for (const double angle : {0.0, 0.5, 2.0, 90.0, 180.0, 301.0}) {
        const auto c = extract_events(coil_record(angle, noise, m.channel, m.coil, 7)).coil;
        CAPTURE(noise, angle, &m - all, c.no_angle);
        REQUIRE(c.closing_angle.known());
        CHECK(std::abs(wrap_half_turn(c.closing_angle.value - radians(angle))) < 3 * c.closing_angle.u);
        CHECK(std::abs(c.switch_on.value) < 3 * c.switch_on.u);
      }
}

TEST_CASE(
    "a rectified coil, or one whose probe is turned round, has no closing angle, and is not called off") {
  for (const double angle : {45.0, 90.0, 190.0, 225.0, 270.0, 300.0, 340.0, 355.0})
    for (const bool rectified : {true, false}) {
      const auto coil =
          rectified ? [](double p) { return std::abs(plain(p)); } : [](double p) { return -plain(p); };
      if (rectified && angle < 180) continue;  // as the mains until their next zero
      const auto c = extract_events(coil_record(angle, 0.15, plain, coil, 7)).coil;
      CAPTURE(angle, rectified);
      CHECK_FALSE(c.closing_angle.known());
      CHECK(c.no_angle.find("does not follow the mains") != std::string::npos);
    }
}

TEST_CASE("a mains that moves or has a tone beside it is in the uncertainty of the closing angle") {
  struct Mains {
    double rate, tone_hertz;  // Hz/s; of 2 % of the amplitude
  };
  for (const auto [rate, tone] :
       {Mains{0.5, 0}, Mains{1, 0}, Mains{4, 0}, Mains{0, 60}, Mains{0, 75}, Mains{0, 120}, Mains{0, 185}}) {
    double z = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      bench::Random random(seed + 40);
      Record r = coil_record(60, 0.15, plain, plain, seed);
      for (auto& c : r.channels)
        for (std::size_t i = 0; i < c.raw.size(); ++i) {
          const double t = (static_cast<double>(i) - 4000) / 1e5,
                       phase = 2 * pi * (50 * t + 0.5 * rate * t * t) + radians(60);
          const double beside =
              tone > 0 ? 6.5 * std::sin(2 * pi * tone * t + 0.3 * static_cast<double>(seed)) : 0.0;
          const double v = c.channel == Channel::coil_voltage && t < 0 ? 0.0 : plain(phase) + beside;
          c.raw[i] = static_cast<std::int16_t>(std::lround((v + 0.15 * random.normal()) / c.scale));
        }
      const auto c = extract_events(r).coil;
      z = std::max(z, std::abs(wrap_half_turn(c.closing_angle.value - radians(60))) / c.closing_angle.u);
    }
    CAPTURE(rate, tone, z);
    CHECK(z < (tone > 0 ? 3 : 2));
  }
}
