#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/firmware_cost.h"
#include "tests/pil/emulated.h"
#include "tests/places.h"

using namespace powbench;

TEST_CASE("the firmware costs at most 5 % more than its baseline", "[pil]") {
  if (!test::emulator_wanted()) return;
  std::ifstream file(test::source_dir() + "/bench/firmware_cost.json");
  const auto baseline = nlohmann::json::parse(file);
  const auto rows = bench::measure_firmware_cost();
  CHECK(rows.size() == baseline.size());
  for (const bench::CostRow& row : rows) {
    INFO(row.name << ": " << row.value << " " << row.unit
                  << "; if that is meant, renew the baseline: bench_emulated_board --baseline "
                     "bench/firmware_cost.json");
    REQUIRE(baseline.contains(row.name));
    CHECK(row.value <= 1.05 * baseline.at(row.name).get<double>());
    if (row.budget > 0) CHECK(row.value <= row.budget);
    if (row.value < 0.95 * baseline.at(row.name).get<double>())
      WARN(row.name << " is " << row.value << " " << row.unit << ": the baseline is too generous, renew it");
  }
}

TEST_CASE("counted instructions are the same at every run", "[pil]") {
  if (!test::emulator_wanted()) return;
  const auto first = bench::measure_firmware_cost(), second = bench::measure_firmware_cost();
  for (std::size_t i = 0; i < first.size(); ++i) {
    INFO(first[i].name);
    CHECK(first[i].value == second[i].value);
  }
}
