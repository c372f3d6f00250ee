#include <catch2/catch.hpp>
#include <cmath>

#include "bench/dsp_synth.h"
#include "dsp/filter/zero_level.h"

using namespace powbench;
using namespace powbench::dsp;
using powbench::bench::Random;

namespace {

constexpr double noise = 0.03;

double contact(double t) {
  if (t > 8e-3 && t < 8.6e-3) return 12 * std::sin(pi * (t - 8e-3) / 0.6e-3);
  return t > 9.2e-3 ? 4 * -std::expm1(-(t - 9.2e-3) / 0.2e-3) : 0.0;
}

Signal film(auto&& zero, double t0 = -40e-3) {
  Random random(21);
  Signal s;
  s.dt = 5e-6, s.t0 = t0;
  for (std::size_t i = 0; i < 16000; ++i)
    s.value.push_back(contact(s.time(i)) + zero(s.time(i)) + noise * random.normal());
  s.masked.assign(s.size(), 0);
  return s;
}

/// N: largest error of the zero, means of 0.2 ms, up to the last touch.
double zero_error(const Signal& s) {
  double worst = 0;
  for (double t = s.t0 + 1e-3; t < 9.2e-3; t += 0.2e-3) {
    double sum = 0;
    for (std::size_t i = s.index_at(t); i < s.index_at(t + 0.2e-3); ++i)
      sum += s.value[i] - contact(s.time(i));
    worst = std::max(worst, std::abs(sum) / 40);
  }
  return worst;
}

}  // namespace

TEST_CASE("a zero that stays is left as it is, to the bit", "[zero]") {
  Signal s = film([](double) { return 0.0; });
  const auto before = s.value;
  CHECK(follow_zero(s, noise, 50).largest == 0.0);
  CHECK(s.value == before);
  Signal tiny;
  tiny.dt = 1e-5, tiny.value = {1, 2, 3}, tiny.masked = {0, 0, 0};
  CHECK(follow_zero(tiny, noise, 50).largest == 0.0);
}

TEST_CASE("hum that jumps at switch-on, and drift, are followed through the bounces", "[zero]") {
  const auto jump = [](double t) {
    return t > 0 ? 0.4 * std::sin(2 * pi * 50 * t + 2) - 0.4 * std::sin(2 * pi * 50 * t) : 0.0;
  };
  Signal s = film(jump);
  const double before = zero_error(s);
  CHECK(follow_zero(s, noise, 50).largest > 0.3);
  CHECK(before > 0.3);
  CHECK(zero_error(s) < 0.05);
  const auto drift = [](double t) { return t > 0 ? -1.2 * -std::expm1(-t / 30e-3) : 2 * t; };
  Signal d = film(drift);
  CHECK(zero_error(d) > 0.15);
  follow_zero(d, noise, 50);
  CHECK(zero_error(d) < 0.05);
}

TEST_CASE("without a pre-trigger hum is followed too; a settled force is no zero", "[zero]") {
  Signal s = film([](double t) { return 0.4 * std::sin(2 * pi * 50 * t); }, -30e-3);
  follow_zero(s, noise, 50);
  CHECK(zero_error(s) < 0.05);
  double sum = 0;
  for (std::size_t i = s.index_at(11e-3); i < s.index_at(31e-3); ++i) sum += s.value[i];
  CHECK(sum / 4000 == Approx(4).margin(0.2));  // a whole period of what is left of the hum
}

TEST_CASE("vibration swings about the zero: its troughs are no open time", "[zero]") {
  // one mode of a struck frame after 10 ms of nothing; the mean of ten of its periods is no force
  double worst = 0;
  for (const double hertz : {1.2e3, 1.5e3, 1.9e3})
    for (const double amplitude : {0.1, 0.3, 0.8})
      for (const double decay : {60.0, 190.0}) {
        Signal s;
        s.dt = 5e-6, s.t0 = -50e-3;
        Random random(static_cast<std::uint64_t>(hertz + 100 * amplitude + decay));
        for (std::size_t i = 0; i < 22000; ++i) {
          const double t = s.time(i) - 10e-3;
          s.value.push_back(noise * random.normal() +
                            (t > 0 ? amplitude * std::exp(-decay * t) * std::sin(2 * pi * hertz * t) : 0.0));
        }
        s.masked.assign(s.value.size(), 0);
        follow_zero(s, noise, 50);
        for (int k = 0; k < 5; ++k) {
          const double from = 10e-3 + 10 * k / hertz;
          double sum = 0, n = 0;
          for (std::size_t i = s.index_at(from); i < s.index_at(from + 10 / hertz); ++i)
            sum += s.value[i], n += 1;
          worst = std::max(worst, std::abs(sum) / n);
        }
      }
  CHECK(worst < 2.5 * noise);  // 0.16 N where single troughs pass for open
}
