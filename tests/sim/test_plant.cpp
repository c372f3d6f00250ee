// The plant's interface: gate, advance, samples, events, ledger.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <vector>

#include "sim/models/plant.h"

using namespace powbench::sim;

namespace {

std::vector<double> grid(double begin, double end, double dt) {
  std::vector<double> t;
  for (int k = 1; begin + k * dt <= end; ++k) t.push_back(begin + k * dt);
  return t;
}

bool same_bits(const PlantSample& a, const PlantSample& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

TEST_CASE("at rest with the coil off nothing is integrated, and the mains goes on") {
  Plant plant({}, {});
  const auto times = grid(0, 0.1, 1e-3);
  std::vector<PlantSample> out(times.size());
  plant.advance(0.1, times, out);
  CHECK(plant.evaluations() == 0);
  CHECK(plant.now() == 0.1);
  for (const auto& p : out) {
    CHECK(p.travel == 0);
    CHECK(p.coil_voltage == 0);
    CHECK(p.mains_voltage ==
          Approx(std::sqrt(2.0) * 230 * std::sin(2 * powbench::pi * 50 * p.time)).margin(1e-9));
  }
}

TEST_CASE("advance in one go and in blocks of 100 us give the same bits") {
  const auto times = grid(0, 0.06, 20e-6);
  std::vector<PlantSample> whole(times.size());
  Plant one({}, {});
  one.gate(true);
  one.advance(0.06, times, whole);

  Plant many({}, {});
  many.gate(true);
  std::vector<PlantSample> parts(times.size());
  std::size_t done = 0;
  for (int block = 1; block <= 600; ++block) {
    const double end = block == 600 ? 0.06 : block * 1e-4;
    std::size_t n = 0;
    while (done + n < times.size() && times[done + n] <= end) ++n;
    many.advance(end, std::span(times).subspan(done, n), std::span(parts).subspan(done, n));
    done += n;
  }
  CHECK(done == times.size());
  std::size_t different = 0;
  for (std::size_t k = 0; k < times.size(); ++k) different += !same_bits(whole[k], parts[k]);
  CHECK(different == 0);
  CHECK(one.events().size() == many.events().size());
}

TEST_CASE("two runs of the same plant agree bit for bit") {
  const auto times = grid(0, 0.05, 1e-4);
  std::vector<PlantSample> first(times.size());
  std::vector<PlantSample> second(times.size());
  for (auto* out : {&first, &second}) {
    Plant plant({}, {});
    plant.gate(true);
    plant.advance(0.05, times, *out);
  }
  for (std::size_t k = 0; k < times.size(); ++k) CHECK(same_bits(first[k], second[k]));
}

TEST_CASE(
    "gate off: the current flows on to its next zero, then the core drops out and everything comes to rest") {
  Plant plant({}, {});
  plant.gate(true);
  plant.advance(0.1, {}, {});
  plant.gate(false);
  CHECK(plant.energy_residual() < 2e-6);
  const auto times = grid(0.1, 1.6, 1e-4);
  std::vector<PlantSample> out(times.size());
  plant.advance(1.6, times, out);
  double opened = 0;
  double released = 0;
  for (const auto& e : plant.events()) {
    if (e.kind == PlantEvent::Kind::coil_open) opened = e.time;
    if (e.kind == PlantEvent::Kind::release_a && e.time > 0.1 && released == 0) released = e.time;
  }
  CHECK(opened > 0.1);
  CHECK(opened < 0.111);
  CHECK(released > opened);
  CHECK(released < 0.15);
  for (const auto& p : out) {
    if (p.time <= opened) continue;
    CHECK(p.coil_current == 0);
    if (p.time > opened + 0.2) CHECK(std::fabs(p.travel) < 1e-5);
  }
  CHECK(plant.energy_residual() < 5e-6);
  const auto cost = plant.evaluations();
  plant.advance(100, {}, {});
  CHECK(plant.evaluations() == cost);  // really at rest
  plant.gate(true);
  plant.advance(100.05, {}, {});
  CHECK(plant.evaluations() > cost);
}

TEST_CASE("gate off in mid-flight: the core returns") {
  Plant plant({}, {});
  plant.gate(true);
  plant.advance(0.008, {}, {});
  plant.gate(false);
  const double t = 0.3;
  PlantSample p;
  plant.advance(t, {&t, 1}, {&p, 1});
  CHECK(std::fabs(p.travel) < 1e-5);
  CHECK(p.force_a == 0);
  CHECK(plant.energy_residual() < 1e-5);
}

TEST_CASE("gate off and on again before the current's zero: the coil stays on") {
  Plant plant({}, {});
  plant.gate(true);
  plant.advance(0.05, {}, {});
  plant.gate(false);
  plant.gate(true);
  const double t = 0.1;
  PlantSample p;
  plant.advance(t, {&t, 1}, {&p, 1});
  for (const auto& e : plant.events()) CHECK(e.kind != PlantEvent::Kind::coil_open);
  CHECK(p.travel > 3e-3);
}

TEST_CASE("gate off in the instant of switching on opens at once: no current has flowed") {
  Plant plant({}, {});
  plant.gate(true);
  plant.gate(false);
  plant.advance(0.05, {}, {});
  REQUIRE(plant.events().size() == 1);
  CHECK(plant.events()[0].kind == PlantEvent::Kind::coil_open);
  CHECK(plant.events()[0].time == 0);
}

TEST_CASE(
    "samples are consistent: pull closes, forces balance the springs, the frame accelerates at the seat") {
  Plant plant({}, {});
  plant.gate(true);
  const double t = 0.3;
  PlantSample p;
  plant.advance(t, {&t, 1}, {&p, 1});
  const Specimen s;
  const double squeeze = s.core.travel - s.bridges.gap;
  CHECK(p.travel - p.base == Approx(s.core.travel).margin(20e-6));
  CHECK(p.force_a == p.force_b);
  CHECK(2 * p.force_a == Approx(s.bridges.preload + s.bridges.rate * squeeze).epsilon(0.05));
  CHECK(p.core_force > 0);
}
