#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>

#include "tests/architecture/tree.h"
#include "tests/places.h"

/// The closing line of `./dev test` must be what the test programs counted, also when one of them ends badly.

using namespace powbench::architecture;

namespace {

/// One program's part of ctest's log.
std::string block(int number, const std::string& name, const std::string& output,
                  const std::string& verdict) {
  return std::to_string(number) + "/4 Testing: " + name + "\nOutput:\n---\n" + output +
         "<end of output>\nTest time =   0.01 sec\n---\n" + verdict + "\n\n";
}

std::string dev(const std::string& verb, const std::string& log) {
  const auto path = std::filesystem::path(powbench::test::build_dir()) / "count-tests.log";
  std::ofstream(path, std::ios::binary) << "Start testing\n---\n" << log << "End testing\n";
  const auto command =
      "bash '" + (project_root() / "dev").string() + "' " + verb + " '" + path.string() + "' 2>&1";
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += static_cast<char>(c);
  REQUIRE(WEXITSTATUS(pclose(pipe)) == 0);
  return said;
}

std::string closing_line(const std::string& log) {
  return dev("count-tests", log);
}

const std::string all_passed = "All tests passed (123 assertions in 12 test cases)\n";

}  // namespace

TEST_CASE("test cases are summed over the programs") {
  CHECK(closing_line(block(1, "core", all_passed, "Test Passed.") +
                     block(2, "dsp", "All tests passed (1 assertion in 1 test case)\n", "Test Passed.")) ==
        "13 passed, 0 failed\n");
}

TEST_CASE("failed test cases are counted, and the passed ones beside them") {
  const std::string some =
      "===\ntest cases:  5 |  4 passed |  1 failed\nassertions: 10 | 9 passed | 1 failed\n";
  CHECK(closing_line(block(1, "core", some, "Test Failed.") + block(2, "dsp", all_passed, "Test Passed.")) ==
        "16 passed, 1 failed\n");
  CHECK(closing_line(block(1, "core", "test cases: 3 | 3 failed\n", "Test Failed.")) ==
        "0 passed, 3 failed\n");
}

TEST_CASE("a program that ends without a summary is one failure") {
  CHECK(closing_line(block(1, "core", all_passed, "Test Passed.") + block(2, "dsp", "", "Test Failed.")) ==
        "12 passed, 1 failed\n");
  CHECK(closing_line(block(1, "core", all_passed, "Test Failed.")) == "12 passed, 1 failed\n");
}

TEST_CASE("a program that closes with a plain count is counted as it says") {
  CHECK(closing_line(block(1, "python", "failed: events: a sentence\n14 passed, 1 failed\n", "Test Failed.") +
                     block(2, "core", all_passed, "Test Passed.")) == "26 passed, 1 failed\n");
  CHECK(dev("report-cases", block(1, "python", "failed: events\n14 passed, 1 failed\n", "Test Failed.")) ==
        "failed: python: events\n");
}

TEST_CASE("a program without matching test cases adds nothing") {
  CHECK(closing_line(block(1, "core.slow", "No test cases matched '[.slow]'\n===\nNo tests ran\n",
                           "Test Passed.")) == "0 passed, 0 failed\n");
}

TEST_CASE("a failed case is named with its sections, once; a program that dies is named too") {
  const std::string rule(79, '-'), dots(79, '.');
  const std::string failure =
      rule + "\na rig that vanishes\n  and stays away\n" + rule + "\nx.cpp:5\n" + dots +
      "\n\nx.cpp:7: FAILED:\n  CHECK( 1 == 2 )\n\nx.cpp:8: FAILED:\n  CHECK( 1 == 3 )\n" +
      "test cases: 1 | 1 failed\n";
  const std::string said = dev("report-cases", block(1, "system", failure, "Test Failed.") +
                                                   block(2, "core", all_passed, "Test Passed.") +
                                                   block(3, "dsp", "Segmentation fault\n", "Test Failed."));
  CHECK(said ==
        "failed: system: a rig that vanishes / and stays away\nfailed: dsp ended without its summary: Test "
        "Failed.\n");
}

TEST_CASE("the ten slowest cases are listed, the slowest first") {
  std::string cases;
  for (int i = 1; i <= 12; ++i) cases += std::to_string(i) + ".5 s: case " + std::to_string(i) + "\n";
  const std::string said = dev("report-cases", block(1, "core", cases + all_passed, "Test Passed."));
  CHECK(std::count(said.begin(), said.end(), '\n') == 10);
  CHECK(said.starts_with("slow:    12.5 s  core: case 12\nslow:    11.5 s  core: case 11\n"));
}
