#include <catch2/catch.hpp>

#include "tests/pil/emulated.h"

using namespace powbench;
using namespace powbench::rigs;
using namespace powbench::test;

TEST_CASE("the emulated board's gate edges take effect at their scheduled ticks", "[pil]") {
  if (!emulator_wanted()) return;
  Client client(emulated_board);
  int edges = 0;
  for (int centi_degrees = 0; centi_degrees < 36000; centi_degrees += 3000) {
    client.control("OUTPUT phase0 raw", std::to_string(centi_degrees));
    client.control("hold_time_ms", "20");
    client.control("arm", "1");
    client.control("fire", "1");
    while (client.world.busy()) client.world.run(0.010);
    const auto scheduled = client.world.scheduled();
    const auto switched = client.world.switched();
    REQUIRE(scheduled.size() == 2);
    REQUIRE(switched.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
      INFO(centi_degrees << " centidegrees, edge " << i);
      CHECK(switched[i].on == scheduled[i].on);
      // an edge that came late would have taken effect at the end of its block
      CHECK(switched[i].at - client.world.plant_time(scheduled[i].at) == 0.0);
      ++edges;
    }
    client.control("abort", "1");
  }
  CHECK(edges == 24);
}
