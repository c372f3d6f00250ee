// The mains: what it says, and what a coil behind it takes, in both models of a closing.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/models/rigid_closing.h"
#include "tests/sim/supply/supply_cases.h"

using namespace powbench;
using namespace powbench::sim;

TEST_CASE("a mains without harmonics and dips is sqrt(2) U sin(w t + phase) to the last bit") {
  Mains m;
  m.phase = 0.3;
  const SupplyModes supply({m, {}});
  for (int k = 0; k < 1000; ++k) {
    const double t = 1.7e-4 * k;
    const double angle = 2 * pi * m.hertz * t + m.phase;
    const double plain = std::sqrt(2.0) * m.volts * sine(angle);
    CHECK(std::fabs(plain - std::sqrt(2.0) * m.volts * std::sin(angle)) < 1e-13);
    CHECK(supply.voltage(t) == plain);
    CHECK(supply.voltage_at(t) == plain);
  }
}

TEST_CASE("harmonics: amplitude and phase of each by correlation over one period, and nothing else") {
  Mains m;
  m.harmonics = {{{3, 0.05, 1.0}, {5, 0.03, -2.0}, {7, 0, 0.4}, {12, 0.01, 3.0}}};
  m.phase = 0.8;
  constexpr int samples = 256;
  for (int order = 1; order < 20; ++order) {
    double s = 0, c = 0;
    for (int k = 0; k < samples; ++k) {
      const double t = k / (samples * m.hertz);
      const double a = order * (2 * pi * m.hertz * t + m.phase);
      const double u = mains_voltage(m, {}, t) / (std::sqrt(2.0) * m.volts) * 2 / samples;
      s += u * std::sin(a);
      c += u * std::cos(a);
    }
    double share = order == 1 ? 1 : 0, phase = 0;
    for (const auto& h : m.harmonics)
      if (h.order == order) {
        share = h.share;
        phase = h.phase;
      }
    CHECK(s == Approx(share * std::cos(phase)).margin(1e-12));
    CHECK(c == Approx(share * std::sin(phase)).margin(1e-12));
  }
}

TEST_CASE("dips: shares multiply and phases jump while they last, from their beginning to before their end") {
  Mains m;
  m.dips = {{{0.02, 0.03, 0.4, 0.5}, {0.04, 0.03, 1.0, 0.2}}};
  const auto piece = [&](double t) { return mains_piece(m, t, 1.0); };
  CHECK(piece(1.019).share == 1);
  CHECK(piece(1.019).end == Approx(1.02));
  CHECK(piece(1.02).share == Approx(0.6));
  CHECK(piece(1.02).jump == 0.5);
  CHECK(piece(1.03).end == Approx(1.04));
  CHECK(piece(1.045).share == 0);
  CHECK(piece(1.045).jump == Approx(0.7));
  CHECK(piece(1.06).jump == 0.2);
  CHECK(piece(1.0701).share == 1);
  CHECK(std::isinf(piece(1.0701).end));
  const double t = 1.03;
  CHECK(mains_voltage(m, piece(t), t) ==
        Approx(0.6 * std::sqrt(2.0) * m.volts * std::sin(2 * pi * m.hertz * t + 0.5)));
}

TEST_CASE(
    "source of R and L: the coil's current against the closed form, and what is left at its terminals") {
  const Specimen s = plain_coil();
  Supply bench;
  bench.mains.resistance = 35;
  bench.mains.inductance = 0.4;
  const double coil = open_inductance(s), inductance = coil + bench.mains.inductance;
  const double resistance = s.coil.resistance + bench.mains.resistance;
  const double omega = 2 * pi * 50;
  const double lag = std::atan2(omega * inductance, resistance);
  const double amplitude = std::sqrt(2.0) * 230 / std::hypot(resistance, omega * inductance);
  for (const double angle : {0.0, 77.0}) {
    const double theta = radians(angle);
    const auto first = simulate(s, at_angle(angle), 0.05, 1e-3, 1e-10, bench);
    const auto rigid = simulate_rigid(s, at_angle(angle), 0.05, 1e-3, 1e-10, true, bench);
    for (const auto* run : {&first, &rigid})
      for (const auto& p : run->samples) {
        const double decay = std::sin(theta - lag) * std::exp(-resistance / inductance * p.time);
        const double i = amplitude * (std::sin(omega * p.time + theta - lag) - decay);
        const double rate =
            amplitude * (omega * std::cos(omega * p.time + theta - lag) + resistance / inductance * decay);
        CHECK(p.coil_current == Approx(i).margin(1e-7 * amplitude));
        CHECK(p.flux_linkage == Approx(coil * i).margin(1e-7 * coil * amplitude));
        CHECK(p.coil_voltage == Approx(s.coil.resistance * i + coil * rate).margin(2e-4));
      }
  }
}

TEST_CASE("flux doubling: switched on at 0 deg a coil without loss reaches twice the flux, at 90 deg once") {
  Specimen s = plain_coil();
  s.coil.resistance = 1e-3;
  const double once = std::sqrt(2.0) * 230 / (2 * pi * 50);  // V / w
  for (const double angle : {0.0, 30.0, 60.0, 90.0}) {
    double most = 0;
    for (const auto& p : simulate(s, at_angle(angle), 0.02, 1e-5, 1e-10).samples)
      most = std::max(most, std::fabs(p.flux_linkage));
    CHECK(most == Approx(once * (1 + std::cos(radians(angle)))).epsilon(3e-5));  // R t / L of it is lost
  }
}

TEST_CASE("a distorted, weak supply with a dip: both models agree on every event and keep their energy") {
  Supply bench;
  bench.mains.resistance = 20;
  bench.mains.inductance = 0.1;
  bench.mains.harmonics[0].share = 0.08;
  bench.mains.harmonics[1] = {5, 0.05, 1.1};
  bench.mains.dips[0] = {4e-3, 3e-3, 0.6, 0.4};
  bench.mains.dips[1] = {30e-3, 8e-3, 1.0, 0};
  for (const double angle : {20.0, 95.0}) {
    const auto first = simulate({}, at_angle(angle), 0.07, 1e-3, 1e-11, bench);
    const auto rigid = simulate_rigid({}, at_angle(angle), 0.07, 1e-3, 1e-10, true, bench);
    REQUIRE((first.truth.core_seat && rigid.truth.core_seat));
    CHECK(*rigid.truth.touch == Approx(*first.truth.touch).margin(1e-8));
    CHECK(*rigid.truth.core_seat == Approx(*first.truth.core_seat).margin(1e-8));
    CHECK(rigid.truth.openings.size() == first.truth.openings.size());
    CHECK(first.energy_residual < 1e-6);
    CHECK(rigid.energy_residual < 1e-6);
    const auto plain = simulate({}, at_angle(angle), 0.07, 0, 1e-8);
    CHECK(std::fabs(*plain.truth.touch - *first.truth.touch) > 1e-4);  // the supply matters
  }
}

TEST_CASE("the corner of a dip is an event: a loose tolerance locates it as a tight one does") {
  Supply bench;
  bench.mains.dips[0] = {3.21e-3, 2.5e-3, 1.0, 0};
  const Specimen s = plain_coil();
  const auto tight = simulate(s, at_angle(40), 0.01, 1e-4, 1e-12, bench);
  const auto loose = simulate(s, at_angle(40), 0.01, 1e-4, 1e-6, bench);
  for (std::size_t k = 0; k < tight.samples.size(); ++k)
    CHECK(loose.samples[k].coil_current == Approx(tight.samples[k].coil_current).margin(1e-6));
  // while interrupted, the mains is exactly dead
  CHECK(tight.samples[40].mains_voltage == 0);
  CHECK(tight.samples[30].mains_voltage != 0);
}

TEST_CASE("mains that cannot be are refused by name") {
  const auto refused = [](auto change) {
    Supply bench;
    change(bench.mains);
    return [bench] { simulate({}, {}, 0.01, 0, 1e-8, bench); };
  };
  CHECK_THROWS_WITH(refused([](Mains& m) { m.resistance = -1; })(), Catch::Contains("mains resistance = -1"));
  CHECK_THROWS_WITH(refused([](Mains& m) { m.inductance = NAN; })(), Catch::Contains("mains inductance"));
  CHECK_THROWS_WITH(refused([](Mains& m) { m.harmonics[2].order = 1; })(), Catch::Contains("harmonic order"));
  CHECK_THROWS_WITH(refused([](Mains& m) { m.harmonics[2].share = 1.5; })(),
                    Catch::Contains("harmonic share"));
  CHECK_THROWS_WITH(refused([](Mains& m) { m.dips[1].depth = 1.01; })(), Catch::Contains("dip depth"));
  CHECK_THROWS_WITH(refused([](Mains& m) { m.dips[0].start = -1e-3; })(), Catch::Contains("dip start"));
}
