#include <catch2/catch.hpp>

#include <algorithm>

#include "tests/architecture/rules.h"
#include "tests/architecture/tree.h"

using namespace powbench::architecture;

namespace {

const std::vector<Source>& project() {
  static const std::vector<Source> sources = read_tree({".h", ".cpp"});
  return sources;
}

bool mentions(const std::vector<std::string>& violations, const std::string& what) {
  return std::any_of(violations.begin(), violations.end(),
                     [&](const std::string& line) { return line.find(what) != std::string::npos; });
}

}  // namespace

// --- the project itself ---

TEST_CASE("the tree is found") {
  for (const auto& folder : folders()) {
    INFO(folder.name);
    CHECK(std::any_of(project().begin(), project().end(),
                      [&](const Source& s) { return s.path.starts_with(std::string(folder.name) + "/"); }));
  }
}

TEST_CASE("includes follow the allowed arrows") {
  const auto wrong = check_arrows(project());
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("third-party headers stay where they belong") {
  const auto wrong = check_third_party(project());
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("the portable firmware reaches no hosted header") {
  const auto wrong = check_firmware_reach(project());
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("neither folders nor files include each other in a circle") {
  const auto wrong = check_cycles(project());
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("no folder of dsp or sim includes a later one") {
  for (const auto* order : {&dsp_order(), &sim_order()}) {
    const auto wrong = check_order(project(), *order);
    INFO(joined(wrong));
    CHECK(wrong.empty());
    for (const auto folder : *order)  // the order names what is there
      CHECK(std::any_of(project().begin(), project().end(),
                        [&](const Source& s) { return s.path.starts_with(std::string(folder) + "/"); }));
  }
  CHECK(mentions(check_order({{"dsp/signal/a.h", "#include \"dsp/filter/b.h\"\n"}}, dsp_order()),
                 "dsp/signal/a.h:1: dsp/filter comes later"));
  CHECK(check_order({{"dsp/events/a.h", "#include \"dsp/options.h\"\n#include \"dsp/signal/b.h\"\n"}},
                    dsp_order())
            .empty());
}

TEST_CASE("files are short and narrow, finished and free of machine paths") {
  const auto wrong = check_text(project());
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("no test sleeps or reads a clock") {
  const auto wrong = check_waiting(project());
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("a file with tests is named test_*.cpp, and no other file is") {
  for (const auto& source : project()) {
    if (!source.path.starts_with("tests/") || !source.path.ends_with(".cpp")) continue;
    INFO(source.path);
    const auto name = source.path.substr(source.path.rfind('/') + 1);
    const bool has_tests = source.text.find("\nTEST_CASE(") != std::string::npos ||
                           source.text.find("\nTEMPLATE_TEST_CASE(") != std::string::npos;
    CHECK(has_tests == name.starts_with("test_"));
  }
}

TEST_CASE("every library of the table has its reason in docs/reference/dependencies.md") {
  const auto page = read_text(project_root() / "docs/reference/dependencies.md");
  for (const auto& allowance : allowances()) {
    INFO(allowance.library);
    CHECK(page.find(allowance.library) != std::string::npos);
  }
}

// --- the checker itself: each rule catches its violation, and only that ---

TEST_CASE("include lines are read as a preprocessor would") {
  const Source s{"dsp/a.cpp",
                 "#include \"core/a.h\"\n// #include \"host/b.h\"\n/* #include <x.h>\n#include <y.h> */\n"
                 "  #  include <vector>\nconst char* t = \"/*\";\n#include \"dsp/c.h\" // why\n"};
  const auto found = includes(s);
  REQUIRE(found.size() == 3);
  CHECK(found[0].target == "core/a.h");
  CHECK(found[0].line == 1);
  CHECK(found[1].target == "vector");
  CHECK(found[1].angled);
  CHECK(found[1].line == 5);
  CHECK(found[2].target == "dsp/c.h");
  CHECK(found[2].line == 7);
}

TEST_CASE("a forbidden arrow is caught") {
  const std::vector<Source> sources{{"core/a.h", "#pragma once\n"},
                                    {"rigs/r.h", "#pragma once\n#include \"core/a.h\"\n"},
                                    {"sim/s.cpp", "#include \"core/a.h\"\n\n#include \"rigs/r.h\"\n"},
                                    {"host/h.cpp", "#include \"rigs/r.h\"\n"}};
  const auto wrong = check_arrows(sources);
  REQUIRE(wrong.size() == 1);
  CHECK(mentions(wrong, "sim/s.cpp:3: sim may not include rigs"));
}

TEST_CASE("relative, missing and unknown includes are caught") {
  CHECK(mentions(check_arrows({{"dsp/a.cpp", "#include \"b.h\"\n"}, {"dsp/b.h", ""}}), "from the top"));
  CHECK(mentions(check_arrows({{"dsp/a.cpp", "#include \"dsp/../core/b.h\"\n"}}), "from the top"));
  CHECK(mentions(check_arrows({{"dsp/a.cpp", "#include \"core/b.h\"\n"}}), "does not exist"));
  CHECK(mentions(check_arrows({{"extras/a.cpp", ""}}), "not in the table"));
}

TEST_CASE("a third-party header in the wrong place is caught") {
  CHECK(check_third_party({{"rigs/iio_link.cpp", "#include <iio.h>\n"}}).empty());
  CHECK(mentions(check_third_party({{"rigs/sensors.cpp", "#include <iio.h>\n"}}), "rigs/sensors.cpp:1"));
  CHECK(mentions(check_third_party({{"host/run/run.cpp", "#include <sqlite3.h>\n"}}), "<sqlite3.h>"));
  CHECK(check_third_party({{"host/store/db.cpp", "#include <sqlite3.h>\n"}}).empty());
  CHECK(mentions(check_third_party({{"host/plan.cpp", "#include <toml++/toml.h>\n"}}), "<toml++/toml.h>"));
  CHECK(check_third_party({{"dsp/fit.cpp", "#include <Eigen/Dense>\n"}}).empty());
  CHECK(mentions(check_third_party({{"dsp/fit.h", "#include <Eigen/Dense>\n"}}), "dsp/fit.h:1"));
  CHECK(mentions(check_third_party({{"dsp/a.cpp", "#include <fftw3.h>\n"}}), "<fftw3.h>"));
  CHECK(mentions(check_third_party({{"core/a.h", "#include <fmt/format.h>\n"}}), "core/a.h:1"));
  CHECK(check_third_party({{"bench/a.cpp", "#include <fftw3.h>\n"}}).empty());
}

TEST_CASE("files and the operating system are caught in the pure folders") {
  CHECK(mentions(check_third_party({{"sim/a.cpp", "#include <fstream>\n"}}), "<fstream>"));
  CHECK(mentions(check_third_party({{"dsp/a.cpp", "#include <sys/socket.h>\n"}}), "<sys/socket.h>"));
  CHECK(check_third_party({{"host/a.cpp", "#include <fstream>\n#include <unistd.h>\n"}}).empty());
}

TEST_CASE("a hosted header behind a core header is caught in the firmware") {
  const std::vector<Source> sources{{"core/a.h", "#include <vector>\n"},
                                    {"core/b.h", "#include \"core/a.h\"\n#include <array>\n"},
                                    {"firmware/f.cpp", "#include \"core/b.h\"\n"}};
  const auto wrong = check_firmware_reach(sources);
  REQUIRE(wrong.size() == 1);
  CHECK(mentions(wrong, "core/a.h:1"));
  CHECK(check_firmware_reach({{"firmware/port/native/main.cpp", "#include <vector>\n"}}).empty());
}

TEST_CASE("circles are caught, between folders and between files") {
  CHECK(mentions(check_cycles({{"dsp/a.h", "#include \"sim/b.h\"\n"}, {"sim/c.h", "#include \"dsp/d.h\"\n"}}),
                 "dsp -> sim -> dsp"));
  CHECK(mentions(check_cycles({{"dsp/a.h", "#include \"dsp/b.h\"\n"}, {"dsp/b.h", "#include \"dsp/a.h\"\n"}}),
                 "dsp/a.h -> dsp/b.h -> dsp/a.h"));
  CHECK(
      check_cycles({{"dsp/a.h", "#include \"core/b.h\"\n"}, {"sim/a.h", "#include \"core/b.h\"\n"}}).empty());
}

TEST_CASE("a test that sleeps or reads a clock is caught") {
  CHECK(mentions(check_waiting({{"tests/rigs/a.cpp", "\nstd::this_thread::sleep_for(5ms);\n"}}),
                 "tests/rigs/a.cpp:2"));
  CHECK(mentions(check_waiting({{"tests/a.h", "auto t = std::chrono::steady_clock::now();\n"}}),
                 "steady_clock"));
  CHECK(mentions(check_waiting({{"tests/a.h", "usleep(5);\n"}}), "tests/waiting.h"));
  CHECK(check_waiting({{"tests/waiting.h", "sleep_for\n"},
                       {"host/a.cpp", "sleep_for\n"},
                       {"tests/b.cpp", "wait_until\n"}})
            .empty());
}

TEST_CASE("long files, wide lines, unfinished work and machine paths are caught") {
  CHECK(mentions(check_text({{"dsp/a.cpp", std::string(401, '\n')}}), "longer than"));
  CHECK(check_text({{"dsp/a.cpp", std::string(400, '\n')}}).empty());
  CHECK(mentions(check_text({{"dsp/a.cpp", "// " + std::string(118, 'x') + "\n"}}), "wider than 120"));
  CHECK(check_text({{"dsp/a.cpp", "// " + std::string(115, 'x') + "\xc2\xb5m\n"}}).empty());
  CHECK(mentions(check_text({{"dsp/a.cpp", std::string("// To") + "Do: later\n"}}), "contains the word"));
  CHECK(check_text({{"dsp/a.cpp", "// today, dumbbells and method\n"}}).empty());
  CHECK(mentions(check_text({{"dsp/a.cpp", std::string("auto p = \"/ho") + "me/me/x\";\n"}}), "one machine"));
  CHECK(mentions(check_text({{"dsp/a.h", "int f();\n"}}), "pragma once"));
}
