#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/architecture/tree.h"
#include "tests/folder.h"

/// The version of a release is written into three files, or into none of them.

using namespace powbench::architecture;

namespace {

namespace fs = std::filesystem;

struct Tree {
  Tree() {
    fs::create_directory(folder / "debian");
    write("CMakeLists.txt",
          "cmake_minimum_required(VERSION 3.25)\nproject(powbench VERSION 1.9.0 LANGUAGES CXX)\n");
    write("CHANGELOG.md",
          "# Changelog\n\n## 1.10.0 (unreleased)\n\nMore.\n\n## 1.9.0 (2026-01-02)\n\nFirst.\n");
    write("debian/changelog",
          "powbench (1.9.0) bookworm; urgency=medium\n\n  * First version.\n\n"
          " -- A Lab <lab@example.invalid>  Fri, 02 Jan 2026 12:00:00 +0000\n");
  }

  void write(const std::string& file, const std::string& text) const {
    std::ofstream(folder / file, std::ios::binary) << text;
  }
  std::string all() const {
    return read_text(folder / "CMakeLists.txt") + read_text(folder / "CHANGELOG.md") +
           read_text(folder / "debian/changelog");
  }
  /// What was said, after the exit code.
  std::string set(const std::string& words) const {
    const std::string command = "cd '" + folder.string() + "' && bash '" +
                                (project_root() / "packaging/set_version.sh").string() + "' " + words +
                                " 2>&1";
    std::FILE* pipe = popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::string said;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += static_cast<char>(c);
    return std::to_string(WEXITSTATUS(pclose(pipe))) + ' ' + said;
  }

  const powbench::test::Folder own;
  const fs::path folder = own.file("");
};

}  // namespace

TEST_CASE("a release states its version in three files") {
  const Tree tree;
  CHECK(tree.set("1.10.0 2026-11-30") == "0 ");
  CHECK_THAT(tree.all(),
             Catch::Contains("project(powbench VERSION 1.10.0 LANGUAGES CXX)") &&
                 Catch::Contains("## 1.10.0 (2026-11-30)\n\nMore.") &&
                 Catch::Contains("powbench (1.10.0) bookworm; urgency=medium\n\n  * See CHANGELOG.md.\n\n"
                                 " -- A Lab <lab@example.invalid>  Mon, 30 Nov 2026 12:00:00 +0000\n\n"
                                 "powbench (1.9.0) bookworm"));
}

TEST_CASE("an entry of the packages that was open is closed by the release") {
  const Tree tree;
  tree.write("debian/changelog",
             "powbench (1.10.0) UNRELEASED; urgency=medium\n\n  * More.\n\n"
             " -- A Lab <lab@example.invalid>  Fri, 02 Jan 2026 12:00:00 +0000\n");
  CHECK(tree.set("1.10.0 2026-11-30") == "0 ");
  CHECK(read_text(tree.folder / "debian/changelog") ==
        "powbench (1.10.0) bookworm; urgency=medium\n\n  * More.\n\n"
        " -- A Lab <lab@example.invalid>  Mon, 30 Nov 2026 12:00:00 +0000\n");
}

TEST_CASE("a release that does not fit its tree changes nothing and says why") {
  const Tree tree;
  const std::string before = tree.all();
  const auto refused = [&](const std::string& words) {
    const std::string said = tree.set(words);
    CHECK(tree.all() == before);
    return said;
  };
  CHECK_THAT(refused("1.8.9 2026-11-30"), Catch::StartsWith("1 ") && Catch::Contains("1.8.9 is below"));
  CHECK_THAT(refused("1.10 2026-11-30"), Catch::StartsWith("1 ") && Catch::Contains("such as 0.2.0"));
  CHECK_THAT(refused("1.11.0 2026-11-30"), Catch::Contains("'## 1.11.0 (unreleased)' is wanted"));
  CHECK_THAT(refused("1.10.0 2026-02-30"), Catch::Contains("no day of the calendar"));
  tree.write("CHANGELOG.md", "# Changelog\n\n## 1.10.0 (unreleased)\n\n## 1.9.0 (2026-01-02)\n\nFirst.\n");
  CHECK_THAT(tree.set("1.10.0 2026-11-30"), Catch::Contains("the section of 1.10.0 is empty"));
}
