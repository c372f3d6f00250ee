// Specimen files of solenoids: what they hold, and every mistake with file, line, key, value and range.

#include "host/config/solenoid_file.h"

#include <catch2/catch.hpp>

#include "host/config/specimen_file.h"
#include "tests/folder.h"
#include "tests/places.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

std::string mistakes_of(const std::string& text) {
  const powbench::test::Folder folder;
  try {
    static_cast<void>(read_solenoid(folder.write("a.specimen.toml", text)));
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the template of a solenoid and its scene can be read") {
  const powbench::test::Folder folder;
  const auto file = folder.write("t.specimen.toml", solenoid_template());
  REQUIRE(is_solenoid_file(file));
  CHECK(read_solenoid(file).design.turns == 1000);
  const auto scene = read_solenoid(powbench::test::source_dir() + "/scenes/solenoid.specimen.toml");
  CHECK(scene.design.steel.name() == "9smnpb28");
  CHECK(scene.design.turns == 957);
  CHECK(scene.travel() == Approx(4.75e-3));
  CHECK(scene.plunger.moving_mass() == Approx(26.04e-3));
}

TEST_CASE("mistakes in a solenoid's file name file, line, key, value and range") {
  const std::string head = "kind = \"solenoid\"\n";
  CHECK_THAT(mistakes_of(head + "[coil]\nturns = 0\n"),
             Contains("a.specimen.toml:3") && Contains("[coil] turns = 0"));
  CHECK_THAT(mistakes_of(head + "[shape]\nface = \"konical\"\n"), Contains("did you mean 'conical'"));
  CHECK_THAT(mistakes_of(head + "[shape]\nbore_radius_mm = 8.0\n"),
             Contains(":3") && Contains("[shape] bore_radius_mm = 8") && Contains("allowed 8.05 .. 500"));
  CHECK_THAT(mistakes_of(head + "[magnet]\ntravel_mm = 30\n"),
             Contains(":3") && Contains("[magnet] travel_mm = 30"));
  CHECK_THAT(mistakes_of(head + "[magnet]\nremanence_T = 0.4\n"),
             Contains(":3") && Contains("remanence_T = 0.4"));
  CHECK_THAT(mistakes_of(head + "[magnet]\nsteel = \"none.csv\"\n"), Contains("none.csv"));
  CHECK_THAT(mistakes_of(head + "[coil]\nhold_turns = 100\n"),
             Contains("hold_from_mm") && Contains("travel_mm"));
  CHECK_THAT(mistakes_of(head + "[bridges]\ngap_mm = 2\n"), Contains("bridges"));
  CHECK_THAT(mistakes_of("kind = \"solenoyd\"\n"), Contains("did you mean 'solenoid'"));
}

TEST_CASE("what takes contactors refuses a solenoid with one sentence") {
  CHECK_THROWS_WITH(read_specimen(powbench::test::source_dir() + "/scenes/solenoid.specimen.toml"),
                    Contains("kind = \"solenoid\"") && Contains("powbench sim"));
  CHECK_FALSE(is_solenoid_file(powbench::test::source_dir() + "/scenes/reference.specimen.toml"));
}
