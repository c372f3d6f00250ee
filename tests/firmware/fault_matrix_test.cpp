#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "bench/fault_cases.h"
#include "tests/places.h"

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

std::string word(firmware::Reaction r) {
  using firmware::Reaction;
  switch (r) {
    case Reaction::gate_off:
      return "coil off";
    case Reaction::open_relay:
      return "coil off, relay open";
    case Reaction::withhold:
      return "edge withheld";
    case Reaction::refuse:
      return "refused";
    case Reaction::next_crossing:
      return "next crossing";
    case Reaction::mark_record:
      return "coil stays off; once on: record marked";
  }
  return "";
}
std::string word(firmware::Watch w) {
  using firmware::Watch;
  return w == Watch::shot      ? "in a shot"
         : w == Watch::always  ? "always"
         : w == Watch::command ? "command"
                               : "start";
}
std::string word(firmware::Clears c) {
  using firmware::Clears;
  return c == Clears::nothing ? "does not latch" : c == Clears::acknowledge ? "abort" : "abort, cause gone";
}

/// A row of the table in docs/reference/faults.md.
std::string page_row(const firmware::FaultInfo& f) {
  std::ostringstream out;
  out << "| " << static_cast<int>(f.fault) << " | `" << f.name << "` | " << f.detection << " | "
      << word(f.reaction) << " | ";
  if (f.limit_us == 0)
    out << "at once";
  else if (f.limit_us < 1000)
    out << f.limit_us << " us";
  else
    out << f.limit_us / 1000.0 << " ms";
  out << " | " << word(f.watch) << " | " << word(f.clears) << " |";
  return out.str();
}

}  // namespace

TEST_CASE("every fault is met within its limit in every state", "[fault]") {
  sweep(45);
}

TEST_CASE("every fault is met within its limit in every state, at 360 phases", "[.slow]") {
  sweep(1);
}

TEST_CASE("the page of the faults says what the table says", "[fault]") {
  std::ifstream file(test::source_dir() + "/docs/reference/faults.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const auto& row : firmware::fault_table) {
    INFO("docs/reference/faults.md needs the line\n" << page_row(row));
    CHECK(text.str().find(page_row(row) + "\n") != std::string::npos);
    INFO("docs/reference/faults.md needs the line\n- `" << row.name << "`: " << row.reason);
    CHECK(text.str().find("- `" + std::string(row.name) + "`: " + std::string(row.reason) + "\n") !=
          std::string::npos);
  }
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
