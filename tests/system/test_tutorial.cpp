// The pages of docs/start, and one of docs/how-to, run as they are written: every `sh` block of a page, in order, in
// one empty folder. A `text` block behind it lists lines that the block must print; `...` stands for anything.
// `$POWBENCH` is the folder of the sources. Where gmsh is not installed its commands are left out: the meshes lie
// beside the outlines.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/folder.h"
#include "tests/places.h"

namespace {

using powbench::test::Folder;
using powbench::test::read_file;

/// A command block of a page and the lines that it must print.
struct Step {
  std::string commands;
  std::vector<std::string> printed;
};

std::vector<Step> steps_of(const std::string& page) {
  enum class In { prose, commands, printed, other };
  std::vector<Step> steps;
  In in = In::prose;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) {
      if (in != In::prose) {
        in = In::prose;
      } else if (line == "```sh") {
        in = In::commands;
        steps.emplace_back();
      } else {
        in = line == "```text" && !steps.empty() ? In::printed : In::other;
      }
    } else if (in == In::commands) {
      steps.back().commands += line + "\n";
    } else if (in == In::printed && line != "...") {
      steps.back().printed.push_back(line);
    }
  }
  return steps;
}

struct Ran {
  int status = 0;
  std::string printed;
};

Ran shell(const Folder& folder, const std::string& commands) {
  static const bool gmsh = std::system("command -v gmsh > /dev/null 2>&1") == 0;
  const std::string script =
      folder.write("step.sh", "POWBENCH='" + powbench::test::source_dir() + "'\n" +
                                  std::string(gmsh ? "" : "gmsh() { :; }\n") + commands);
  const std::string program = powbench::test::program(), bin = program.substr(0, program.rfind('/'));
  const std::string line = "cd '" + folder.file("") + "' && PATH='" + bin +
                           "':\"$PATH\" bash -euo pipefail '" + script + "' 2>&1 </dev/null";
  Ran ran;
  std::FILE* pipe = popen(line.c_str(), "r");
  REQUIRE(pipe != nullptr);
  for (char buffer[4096]; const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe);)
    ran.printed.append(buffer, n);
  ran.status = pclose(pipe);
  return ran;
}

void run_page(const std::string& name, std::size_t most = 100) {
  const Folder folder;
  const auto steps = steps_of(read_file(powbench::test::source_dir() + "/docs/" + name));
  REQUIRE(steps.size() >= 2);
  for (std::size_t k = 0; k < std::min(most, steps.size()); ++k) {
    const Step& step = steps[k];
    const Ran ran = shell(folder, step.commands);
    INFO(name << ":\n" << step.commands << "printed:\n" << ran.printed);
    REQUIRE(ran.status == 0);
    for (const std::string& line : step.printed) {
      INFO("wanted: " << line);
      CHECK(ran.printed.find(line) != std::string::npos);
    }
  }
}

}  // namespace

TEST_CASE("tutorial steps: commands and what they must print", "[tutorial]") {
  const auto steps =
      steps_of("a\n```sh\none\ntwo\n```\n```text\nx\n...\ny\n```\n```toml\nz = 1\n```\n```sh\nthree\n```\n");
  REQUIRE(steps.size() == 2);
  CHECK(steps[0].commands == "one\ntwo\n");
  CHECK(steps[0].printed == std::vector<std::string>{"x", "y"});
  CHECK(steps[1].printed.empty());
  const Folder folder;
  CHECK(shell(folder, "echo out; false | true; echo never\n").status != 0);
}

TEST_CASE("tutorials: every page of docs/start has a test", "[tutorial]") {
  for (const auto& file : std::filesystem::directory_iterator(powbench::test::source_dir() + "/docs/start")) {
    const std::string name = file.path().filename().string();
    CHECK(
        std::set<std::string>{"first-campaign.md", "oscilloscope-file.md", "own-specimen.md", "best-angle.md"}
            .contains(name));
  }
}

TEST_CASE("tutorial: the first campaign", "[tutorial]") {
  run_page("start/first-campaign.md");
}

TEST_CASE("how-to: a magnet of one's own, from drawing and steel sheet to a closing", "[tutorial][.slow]") {
  run_page("how-to/own-magnet.md", 5);  // all but the closing with a ring, whose table takes a minute
}

TEST_CASE("how-to: all of a magnet of one's own", "[tutorial][.long]") {
  run_page("how-to/own-magnet.md");
}

TEST_CASE("how-to: a DC solenoid, from drawing and steel sheet to a closing", "[tutorial][.slow]") {
  run_page("how-to/solenoid.md");
}

TEST_CASE("tutorial: a file of an oscilloscope", "[tutorial]") {
  run_page("start/oscilloscope-file.md");
}

TEST_CASE("tutorial: a contactor from its data sheet", "[tutorial]") {
  run_page("start/own-specimen.md");
}

TEST_CASE("tutorial: from records to the best closing angle", "[.slow]") {
  run_page("start/best-angle.md");
}
