#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/places.h"
#include "tests/port/scenario.h"

using namespace powbench::test;

TEST_CASE("scenario files: what is no statement is refused with its line", "[port]") {
  const auto path = std::filesystem::temp_directory_path() / "powbench_scenario_test.scenario";
  const auto refused = [&](const char* line) {
    std::ofstream(path) << "# what is shown\n" << line << "\n";
    try {
      read_scenario(path);
    } catch (const std::runtime_error& e) {
      return std::string(e.what()).find("scenario:2: no statement") != std::string::npos;
    }
    return false;
  };
  for (const char* line :
       {"gate of within 120 us", "gate off within 120", "gate off within 120 s", "wait two ms", "set arm",
        "until fault 12 emergency_stop 2 ms", "fire", "held 20 ms", "relay out"})
    CHECK(refused(line));
  CHECK_FALSE(refused("gate off within 120 us  # a comment"));
  std::filesystem::remove(path);
  CHECK_THROWS(read_scenario(path));
}

TEST_CASE("scenario files: docs/how-to/porting.md lists each with its first line", "[port]") {
  std::ifstream page(powbench::test::source_dir() + "/docs/how-to/porting.md");
  std::string text;
  std::size_t rows = 0, files = 0;
  bool table = false;
  for (std::string line; std::getline(page, line); text += line + '\n') {
    table = line == "| scenario | shows |" || (table && line.starts_with("|"));
    rows += table;
  }
  for (const auto& entry :
       std::filesystem::directory_iterator(powbench::test::source_dir() + "/tests/port/scenarios")) {
    std::ifstream file(entry.path());
    std::string first;
    std::getline(file, first);
    CHECK(text.find("| `" + entry.path().stem().string() + "` | " + first.substr(2) + " |\n") !=
          std::string::npos);
    ++files;
  }
  CHECK(rows == files + 2);
}
