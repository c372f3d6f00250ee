#include <catch2/catch.hpp>

#include <array>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "sim/team.h"

namespace powbench::sim {

TEST_CASE("a team calls every worker once a job, also for many short jobs") {
  Team team(3);
  std::array<int, 3> calls{};
  for (int k = 0; k < 1000; ++k) team.run([&](int worker) { ++calls[static_cast<std::size_t>(worker)]; });
  CHECK(calls == std::array{1000, 1000, 1000});
}

TEST_CASE("every index is visited once") {
  Team team(2);
  std::vector<int> visits(1000);
  for_each_index(team, 1000, [&](int k) { ++visits[static_cast<std::size_t>(k)]; });
  CHECK(visits == std::vector<int>(1000, 1));
}

TEST_CASE("a team passes on an exception and can work again") {
  Team team(2);
  CHECK_THROWS_AS(team.run([](int worker) {
    if (worker == 1) throw std::runtime_error("no");
  }),
                  std::runtime_error);
  int sum = 0;
  team.run([&](int worker) {
    if (worker == 0) sum = 7;
  });
  CHECK(sum == 7);
  CHECK_THROWS_AS(Team(0), std::invalid_argument);
}

}  // namespace powbench::sim
