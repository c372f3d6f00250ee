#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>

#include "host/plan/expand.h"

using namespace powbench;
using namespace powbench::host;

namespace {

Plan plan_of(const std::string& rest, int repeats = 3) {
  return parse_plan(
      "angles_deg = {start = 0, stop = 180, step = 30}\nrepeats = " + std::to_string(repeats) + "\n" + rest,
      "p");
}

std::vector<double> angles_of(const std::vector<PlannedShot>& shots) {
  std::vector<double> all;
  for (const auto& s : shots) all.push_back(s.conditions.closing_angle);
  return all;
}

}  // namespace

TEST_CASE("every block holds every angle once, in any order", "[plan]") {
  for (const char* order : {"order = \"random\"\n", "order = \"sequential\"\n"}) {
    const auto shots = expand(plan_of(order));
    REQUIRE(shots.size() == 21);
    for (int r = 0; r < 3; ++r) {
      std::set<double> seen;
      for (int k = 0; k < 7; ++k) {
        const auto& s = shots[static_cast<std::size_t>(7 * r + k)];
        CHECK(s.index == 7 * r + k);
        CHECK(s.repeat == r);
        seen.insert(s.conditions.closing_angle);
      }
      CHECK(seen.size() == 7);
    }
  }
}

TEST_CASE("the order follows from the seed alone and differs between blocks and seeds", "[plan]") {
  const auto first = angles_of(expand(plan_of("seed = 20\n")));
  CHECK(first == angles_of(expand(plan_of("seed = 20\nsupply_volts = 100\n"))));
  CHECK(first != angles_of(expand(plan_of("seed = 21\n"))));
  CHECK(std::vector<double>(first.begin(), first.begin() + 7) !=
        std::vector<double>(first.begin() + 7, first.begin() + 14));
  // more repeats only append: a longer plan begins with the shorter one
  const auto longer = angles_of(expand(plan_of("seed = 20\n", 5)));
  CHECK(std::vector<double>(longer.begin(), longer.begin() + 21) == first);
}

TEST_CASE("the order for a seed is the same on every machine", "[plan]") {
  std::string order;
  for (const auto& s : expand(plan_of("seed = 20\n", 1)))
    order += std::to_string(static_cast<int>(degrees(s.conditions.closing_angle) + 0.5)) + " ";
  CHECK(order == "30 150 90 180 60 120 0 ");
  CHECK(shot_seed(20, 0) == 7024113935948520ULL);
}

TEST_CASE("every angle comes to every place of a block equally often", "[plan]") {
  std::array<std::array<int, 7>, 7> counts{};
  constexpr int blocks = 7000;
  const auto shots = expand(plan_of("seed = 5\n", blocks));
  for (const auto& s : shots)
    ++counts[static_cast<std::size_t>(s.index % 7)]
            [static_cast<std::size_t>(degrees(s.conditions.closing_angle) / 30 + 0.5)];
  double chi_square = 0;
  for (const auto& row : counts)
    for (const int n : row) chi_square += (n - blocks / 7.0) * (n - blocks / 7.0) / (blocks / 7.0);
  CHECK(chi_square < 68.0);  // 99.9 % point for 36 degrees of freedom
}

TEST_CASE("shot seeds differ, fit 53 bits and do not depend on the order", "[plan]") {
  std::set<std::uint64_t> seen;
  for (std::uint64_t plan_seed = 0; plan_seed < 50; ++plan_seed)
    for (int i = 0; i < 200; ++i) {
      const auto seed = shot_seed(plan_seed, i);
      REQUIRE(seed < (1ULL << 53));
      seen.insert(seed);
    }
  CHECK(seen.size() == 50 * 200);
  const auto random = expand(plan_of("seed = 3\n"));
  const auto sequential = expand(plan_of("seed = 3\norder = \"sequential\"\n"));
  for (std::size_t i = 0; i < random.size(); ++i)
    CHECK(random[i].conditions.seed == sequential[i].conditions.seed);
}

TEST_CASE("conditions are the plan's", "[plan]") {
  const auto shots =
      expand(plan_of("supply_volts = 207\nmains_hertz = 60\nhold_time_ms = 80\nambient_degC = 40\n"), "K1");
  const Conditions& c = shots.front().conditions;
  CHECK(c.supply_volts == 207.0);
  CHECK(c.mains_hertz == 60.0);
  CHECK(c.hold_time == 0.08);
  CHECK(c.ambient == 313.15);
  CHECK(c.specimen == "K1");
  CHECK(c.polarity == +1);
}

TEST_CASE("alternating polarity reaches every angle with both signs", "[plan]") {
  for (const char* angles : {"[0, 30, 60]", "[0, 30, 60, 90]"}) {
    const Plan plan = parse_plan(
        std::string("repeats = 4\norder = \"sequential\"\npolarity = \"alternate\"\nangles_deg = ") + angles +
            "\n",
        "p");
    std::map<double, int> balance;
    for (const auto& s : expand(plan)) balance[s.conditions.closing_angle] += s.conditions.polarity;
    for (const auto& [angle, sum] : balance) CHECK(sum == 0);
  }
  CHECK(expand(plan_of("polarity = \"negative\"\n")).front().conditions.polarity == -1);
}

TEST_CASE("the time estimate adds up", "[plan]") {
  CHECK(estimated_seconds(plan_of("hold_time_ms = 100\npause_s = 10\n"), 0.4) == Approx(21 * 0.5 + 20 * 10));
}
