#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "firmware/faults.h"
#include "tests/pil/emulated.h"
#include "tests/places.h"
#include "tests/port/board_driver.h"
#include "tests/port/scenario.h"

/// Every scenario on the firmware in this program and on the emulated processor. The image for the board plays them
/// in the replay.

using namespace powbench;
using namespace powbench::test;

namespace {

std::set<std::filesystem::path> scenarios() {
  std::set<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_dir() + "/tests/port/scenarios"))
    found.insert(entry.path());
  return found;
}

int play_all(const rigs::BoardOptions& options) {
  int played = 0;
  for (const auto& path : scenarios()) {
    INFO(path.filename().string());
    BoardDriver driver(options);
    const Played outcome = play(read_scenario(path), driver);
    CHECK(outcome.failure == "");
    played += outcome.played;
  }
  return played;
}

/// A port that has forgotten one of its inputs.
class Deaf final : public BoardDriver {
 public:
  explicit Deaf(std::string input) : BoardDriver(native), input_(std::move(input)) {}
  void cause(const std::string& name, bool begins) override {
    if (name != input_) BoardDriver::cause(name, begins);
  }

 private:
  std::string input_;
};

std::string failure(const std::string& scenario, const char* input) {
  Deaf driver(input);
  return play(read_scenario(test::source_dir() + "/tests/port/scenarios/" + scenario + ".scenario"), driver)
      .failure;
}

}  // namespace

TEST_CASE("conformance: the native port", "[port]") {
  CHECK(play_all(native) == static_cast<int>(scenarios().size()) - 2);  // the two that need a reset
}

TEST_CASE("conformance: the emulated port", "[port]") {
  if (!emulator_wanted()) return;
  CHECK(play_all(counting) == static_cast<int>(scenarios().size()) - 2);
}

TEST_CASE("conformance: a port that has forgotten an input is found", "[port]") {
  for (const auto& [scenario, input] : {std::pair{"stop", "stop_open"},
                                        {"overcurrent", "overcurrent"},
                                        {"samples", "samples_lost"},
                                        {"supply", "supply_low"}})
    CHECK(failure(scenario, input).find("gate off within") != std::string::npos);
  CHECK(failure("stop_ahead", "stop_open").find("it was on") != std::string::npos);
  CHECK(failure("relay_welded", "relay_welded").find("21 relay_welded") != std::string::npos);
  CHECK(failure("laser", "laser_out").find("accepted") != std::string::npos);
}
