#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/models/lanes/lane_block.h"
#include "sim/models/lanes/plant_lanes.h"
#include "sim/supply/sine.h"

/// Plants side by side are the plants alone, to the bit.

using namespace powbench;
using namespace powbench::sim;

namespace {

struct Scene {
  Specimen specimen;
  Conditions conditions;
  Supply bench;
  double tolerance = 1e-6, off = 0.05;
};

/// One of the shapes a specimen can have, its numbers drawn about those of the reference.
Scene drawn(Random& random, int shape) {
  Scene s;
  const auto about = [&](double& number, double share) { number *= 1 + share * (2 * random.uniform() - 1); };
  about(s.specimen.core.mass, 0.3), about(s.specimen.core.friction, 0.9),
      about(s.specimen.core.return_preload, 0.3);
  about(s.specimen.bridges.gap, 0.2), about(s.specimen.bridges.preload, 0.3),
      about(s.specimen.bridges.mass, 0.3);
  about(s.specimen.base.hertz, 0.5), about(s.specimen.magnet.residual_gap, 0.3);
  s.conditions.closing_angle = 2 * pi * random.uniform();
  s.conditions.supply_volts = 150 + 110 * random.uniform();
  s.conditions.mains_hertz = 45 + 20 * random.uniform();
  s.tolerance = random.uniform() < 0.5 ? 1e-5 : 1e-8;
  if (shape == 1) s.specimen.bridges.tilt_gap = 0.1e-3 * random.uniform();
  if (shape == 2) s.specimen.bridges.gap_spread = 0.1e-3 * random.uniform();
  if (shape == 3) s.specimen.base.core_mass = 0.05;
  if (shape == 4) s.specimen.magnet.shaded_share = 0;
  if (shape == 5) s.specimen.core.friction = 0;
  // these the lanes do not know
  if (shape == 6) s.specimen.magnet.bh_exponent = 8.5;
  if (shape == 7) s.specimen.magnet.coercive_field = 60, s.specimen.magnet.remanence = 0.5;
  if (shape == 8)
    s.bench.coil_switch.kind = CoilSwitch::Kind::triac, s.bench.coil_switch.latching_current = 0.01;
  if (shape == 9) s.off = 0.012;  // and so is what follows the switching off
  if (shape == 10) s.bench.mains.harmonics[0].share = 0.05, s.bench.mains.dips[0] = {0.004, 0.003, 0.6, 0.3};
  return s;
}
constexpr int shapes = 11;

/// Contacts so stiff that rounding alone is more than the tolerance: steps become too small.
Scene refused() {
  Scene s;
  s.tolerance = 1e-14;
  s.conditions.supply_volts = 1e4;
  s.specimen.core.stop_stiffness = 1e12;
  s.specimen.bridges.contact_stiffness = s.specimen.bridges.seat_stiffness = 1e12;
  return s;
}

Plant plant_of(const Scene& s) {
  return closing_plant(s.specimen, s.conditions, s.tolerance, s.bench);
}

void finish(Plant& p, const Scene& s) {
  p.gate(false);
  p.advance(s.off + 0.02, {}, {});
}

bool same(const Plant& a, const Plant& b) {
  if (a.events().size() != b.events().size() || a.supplied_energy() != b.supplied_energy() ||
      a.energy_residual() != b.energy_residual())
    return false;
  for (std::size_t i = 0; i < a.events().size(); ++i) {
    const PlantEvent &x = a.events()[i], &y = b.events()[i];
    if (x.kind != y.kind || x.time != y.time || x.velocity != y.velocity) return false;
  }
  return true;
}

/// How many of the scenes come out otherwise in lanes.
int others(const std::vector<Scene>& scenes) {
  std::vector<std::unique_ptr<Plant>> lanes;
  for (const Scene& s : scenes) lanes.push_back(std::make_unique<Plant>(plant_of(s)));
  std::size_t next = 0, ended = 0;
  advance_in_lanes(
      [&]() -> LaneRun {
        if (next == scenes.size()) return {};
        const std::size_t i = next++;
        return {lanes[i].get(), scenes[i].off};
      },
      [&](Plant& p) {
        ++ended;
        CHECK(p.now() > 0);
      });
  CHECK(ended == scenes.size());
  int count = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    Plant alone = plant_of(scenes[i]);
    alone.advance(scenes[i].off, {}, {});
    finish(alone, scenes[i]);
    finish(*lanes[i], scenes[i]);
    count += same(alone, *lanes[i]) ? 0 : 1;
  }
  return count;
}

}  // namespace

TEST_CASE("plants in lanes are plants alone to the bit, whatever their shape", "[lanes]") {
  for (int shape = 0; shape < shapes; ++shape) {
    Random random(static_cast<std::uint64_t>(shape) + 1);
    std::vector<Scene> scenes;
    for (int i = 0; i < 24; ++i) scenes.push_back(drawn(random, shape));
    INFO("shape " << shape);
    CHECK(others(scenes) == 0);
  }
}

TEST_CASE("plants of every shape share the lanes, in any number", "[lanes]") {
  Random random(77);
  for (const int count : {0, 1, 7, 8, 9, 60}) {
    std::vector<Scene> scenes;
    for (int i = 0; i < count; ++i) scenes.push_back(drawn(random, static_cast<int>(random.below(shapes))));
    INFO(count);
    CHECK(others(scenes) == 0);
  }
}

TEST_CASE("what refuses to be integrated refuses in lanes too", "[lanes]") {
  Random random(5);
  std::vector<Scene> scenes{drawn(random, 0), drawn(random, 0)};
  scenes[1] = refused();
  const auto alone = [&] { plant_of(scenes[1]).advance(scenes[1].off, {}, {}); };
  const auto beside = [&] { others(scenes); };
  std::string first, second;
  try {
    alone();
  } catch (const std::runtime_error& e) {
    first = e.what();
  }
  try {
    beside();
  } catch (const std::runtime_error& e) {
    second = e.what();
  }
  CHECK_THAT(first, Catch::Contains("the step became too small"));
  CHECK(first == second);
}

TEST_CASE("a plant that fails leaves its lane to the next, which is asked for again", "[lanes]") {
  Random random(6);
  std::vector<Scene> scenes;
  for (int i = 0; i < 12; ++i) scenes.push_back(drawn(random, 0));
  for (const std::size_t i : {2U, 9U}) scenes[i] = refused();
  std::vector<std::unique_ptr<Plant>> lanes;
  for (const Scene& s : scenes) lanes.push_back(std::make_unique<Plant>(plant_of(s)));
  // one alone until it has ended, then two, then the rest
  std::size_t next = 0, ended = 0;
  int failed = 0;
  advance_in_lanes(
      [&]() -> LaneRun {
        if (next == scenes.size() || next > 2 * ended) return {};
        const std::size_t i = next++;
        return {lanes[i].get(), scenes[i].off};
      },
      [&](Plant&) { ++ended; },
      [&](Plant& p) {
        ++ended;
        CHECK((&p == lanes[2].get() || &p == lanes[9].get()));
        ++failed;
      });
  CHECK(ended == scenes.size());
  CHECK(failed == 2);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (i == 2 || i == 9) continue;
    Plant alone = plant_of(scenes[i]);
    alone.advance(scenes[i].off, {}, {});
    CHECK(same(alone, *lanes[i]));
  }
}

TEST_CASE("the mains' sine is that of the library to 2.5e-16", "[lanes]") {
  Random random(3);
  double worst = 0;
  for (int i = 0; i < 200'000; ++i) {
    const double size = i % 3 == 0 ? 1e6 : i % 3 == 1 ? 100 : 4;
    const double x = size * (2 * random.uniform() - 1);
    worst = std::max(worst, static_cast<double>(std::fabs(static_cast<long double>(sine(x)) -
                                                          std::sin(static_cast<long double>(x)))));
  }
  for (int n = -1000; n <= 1000; ++n) worst = std::max(worst, std::fabs(sine(n * pi) - std::sin(n * pi)));
  CHECK(worst < 2.5e-16);
  CHECK(sine(0.0) == 0);
  CHECK(sine(1e9) == std::sin(1e9));
  CHECK(std::isnan(sine(HUGE_VAL)));
}

#ifdef __x86_64__
TEST_CASE("every instruction set gives the same bits", "[lanes]") {
  const int shape = GENERATE(0, 1, 2, 3);
  INFO("shape " << shape);
  Random random(9);
  LaneLayout layout;
  auto start = std::make_unique<LaneBlock>();
  for (int k = 0; k < lane_width; ++k) {
    const Scene s = drawn(random, shape);
    const Mains mains = closing_mains(s.conditions, s.bench.mains);
    ContactorModel model(s.specimen, mains, closing_options(s.conditions));
    ContactorModel::State y = model.rest();
    model.set_coil(0, y.data(), true);
    REQUIRE(model.lane_layout(layout));
    model.put_numbers(*start, k);
    model.put_modes(*start, k);
    const auto lane = static_cast<std::size_t>(k);
    start->step[lane] = 1e-5 * (1 + random.uniform());
    for (std::size_t i = 0; i < static_cast<std::size_t>(layout.size); ++i) {
      start->y[i][lane] = y[i] + 1e-4 * random.uniform();
      start->tolerance[i][lane] = 1e-8 * model.scale(static_cast<int>(i));
      start->first_slope[i][lane] = random.uniform();
    }
    start->one_sine[lane] = k % 2 == 0 ? -1 : 0;
    start->amplitude[lane] = 325;
    start->begin[lane] = random.uniform();
    start->rate[lane] = 300 + 80 * random.uniform();
    start->phase[lane] = 7 * random.uniform();
    for (auto& source : start->source) source[lane] = 300 * random.uniform();
  }
  const auto stepped = [&](LaneKernel kernel) {
    auto block = std::make_unique<LaneBlock>(*start);
    kernel(layout, *block);
    return block;
  };
  const auto portable = stepped(portable_lane_kernel);
  CHECK(portable->error[0] > 0);
  const auto check = [&](LaneKernel kernel) {
    const auto other = stepped(kernel);
    for (std::size_t i = 0; i < static_cast<std::size_t>(layout.size); ++i)
      CHECK(other->result[i] == portable->result[i]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(layout.contacts); ++i)
      CHECK(other->guard[3][i] == portable->guard[3][i]);
    CHECK(other->error == portable->error);
    CHECK(other->interesting == portable->interesting);
  };
  if (__builtin_cpu_supports("avx2")) check(avx2_lane_kernel);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) check(avx512_lane_kernel);
}
#endif
