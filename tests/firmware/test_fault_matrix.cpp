#include <catch2/catch.hpp>

#include "bench/fault_cases.h"

using namespace powbench;
using bench::FaultCases;
using bench::Start;

namespace {

void sweep(int step) {
  FaultCases cases;
  int worst_over = 0;
  for (const auto& row : firmware::fault_table)
    for (const Start start : {Start::idle, Start::armed, Start::scheduled, Start::energised})
      for (int phase = 0; phase < 360; phase += step) {
        const auto result = cases.run(row.fault, start, phase);
        worst_over += result.passed ? 0 : 1;
        INFO(row.name << ", " << bench::start_names[static_cast<std::size_t>(start)] << ", " << phase
                      << " deg: " << result.why << ", " << result.reaction_us << " us of " << row.limit_us);
        CHECK(result.passed);
      }
  CHECK(worst_over == 0);
}

}  // namespace

TEST_CASE("every fault is met within its limit in every state", "[fault]") {
  sweep(45);
}

TEST_CASE("every fault is met within its limit in every state, at 360 phases", "[.slow]") {
  sweep(1);
}

TEST_CASE("the table is numbered as it stands and every latching fault says what to do", "[fault]") {
  int number = 0;
  for (const auto& row : firmware::fault_table) {
    CHECK(static_cast<int>(row.fault) == ++number);
    CHECK(&firmware::info(row.fault) == &row);
    CHECK(row.reason.size() < 120);
    CHECK(row.reason.find(':') != std::string_view::npos);
  }
}
