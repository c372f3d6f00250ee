#include <catch2/catch.hpp>

#include "tests/architecture/reach.h"
#include "tests/architecture/rules.h"
#include "tests/architecture/tree.h"

using namespace powbench::architecture;

namespace {

const Source program{"host/main.cpp", "#include \"dsp/a.h\"\nint main() {\n  return used(1);\n}\n"};
const Source header{"dsp/a.h", "#pragma once\nint used(int);\n"};
const Source body{"dsp/a.cpp", "#include \"dsp/a.h\"\nint used(int x) {\n  return x;\n}\n"};

}  // namespace

TEST_CASE("every file and every function of the product is reached from a program, but for a list") {
  const auto sources = read_tree({".h", ".cpp"});
  const auto files = check_reached(files_not_reached(sources), unreached_files());
  INFO(joined(files));
  CHECK(files.empty());
  const auto functions =
      check_reached(functions_not_reached(sources), unreached_functions(), called_from_outside());
  INFO(joined(functions));
  CHECK(functions.empty());
}

TEST_CASE("a rule is written once") {
  const auto wrong = check_said_once(read_tree({".h", ".cpp"}));
  INFO(joined(wrong));
  CHECK(wrong.empty());
  const std::string twice = "double p = a + (c.polarity < 0 ? pi : 0.0);\n";
  CHECK(check_said_once({{"dsp/a.cpp", twice}}).size() == 1);
  CHECK(check_said_once({{"core/commanded_phase.h", twice}, {"dsp/a.cpp", "// polarity < 0\n"}}).empty());
}

TEST_CASE("what a program needs is reached, also a source that defines what another's header declares") {
  CHECK(files_not_reached({program, header, body}).empty());
  CHECK(functions_not_reached({program, header, body}).empty());
  CHECK(files_not_reached({program, header, {"dsp/b.cpp", "int used(int x) {\n  return x;\n}\n"}}).empty());
}

TEST_CASE("a file that tests and benchmarks alone include is caught") {
  const std::vector<Source> sources{
      program,
      header,
      body,
      {"dsp/old.h", "#pragma once\nint old(int);\n"},
      {"dsp/old.cpp", "#include \"dsp/old.h\"\nint old(int x) {\n  return used(x);\n}\n"},
      {"bench/b.cpp", "#include \"dsp/old.h\"\nint main() {\n  return old(1);\n}\n"},
      {"tests/dsp/t.cpp", "#include \"dsp/old.h\"\nint x = old(1);\n"}};
  const auto wrong = check_reached(files_not_reached(sources), {});
  REQUIRE(wrong.size() == 2);
  CHECK(wrong[0].starts_with("dsp/old.cpp: "));
  CHECK(wrong[1].starts_with("dsp/old.h: "));
}

TEST_CASE("a function that tests alone call is caught; a comment or a literal with its name is no call") {
  const Source more{"dsp/a.h",
                    "#pragma once\nint used(int);\n/// Like spare().\nint spare(int);\nstruct S {\n"
                    "  const int& held() const;\n  int inner() const { return hidden(); }\n"
                    "  int hidden() const { return 1; }\n};\n"};
  const Source makes{
      "dsp/a.cpp",
      "#include \"dsp/a.h\"\nint used(int x) {\n  return x + S().inner() + \"spare(1)\"[0];\n}\n"
      "int spare(int x) {\n  return x;\n}\nconst int& S::held() const {\n  return 1'000;\n}\n"};
  const auto found = functions_not_reached({program, more, makes, {"tests/t.cpp", "int x = spare(1);\n"}});
  REQUIRE(found.size() == 2);
  CHECK((found[0].name == "held" && found[0].where == "dsp/a.h:6"));
  CHECK((found[1].name == "spare" && found[1].where == "dsp/a.h:4"));
  CHECK(check_reached(found, {"held", "spare"}).empty());
  CHECK(check_reached(found, {"held"}, {"spare"}).empty());
  CHECK(check_reached(found, {"spare"}).size() == 1);
  CHECK(check_reached({}, {"spare"}).size() == 1);
}

TEST_CASE("code is what remains without comments and literals") {
  CHECK(code_of("a /* b */ c // d\ne") == "a         c     \ne");
  CHECK(code_of("x(\"a\\\"b\", 'c', 1'000, R\"s(q)\" )s\")") == "x(\"    \", ' ', 1'000, R\"        \")");
}
