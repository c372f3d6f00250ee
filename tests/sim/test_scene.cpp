// The scene file of the reference specimen says what the program's defaults say.

#include <toml++/toml.h>
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "sim/specimen/specimen_fields.h"
#include "tests/places.h"

using namespace powbench::sim;

TEST_CASE("scenes/reference.specimen.toml holds every number of the reference specimen and no other key") {
  const auto file = toml::parse_file(powbench::test::source_dir() + "/scenes/reference.specimen.toml");
  const Specimen defaults;
  CHECK(file["name"].value<std::string>() == defaults.name);
  std::set<std::string> known{"name"};
  for (const auto& f : specimen_fields()) {
    const auto value = file[f.section][f.key].value<double>();
    CAPTURE(f.section, f.key);
    REQUIRE(value);
    CHECK(*value * f.si_per_unit == Approx(f.get(defaults)).epsilon(1e-12));
    known.insert(std::string(f.section) + "." + std::string(f.key));
  }
  for (const auto& [section, node] : file) {
    if (!node.is_table()) {
      CHECK(known.count(std::string(section.str())) == 1);
      continue;
    }
    for (const auto& [key, value] : *node.as_table()) {
      const std::string full = std::string(section.str()) + "." + std::string(key.str());
      CAPTURE(full);
      CHECK(known.count(full) == 1);
    }
  }
}

TEST_CASE("each field of the table reads what it writes and touches nothing else") {
  const auto fields = specimen_fields();
  for (const auto& f : fields) {
    Specimen s;
    f.set(s, f.get(s) + 1);
    for (const auto& other : fields) CHECK(other.get(s) == other.get(Specimen{}) + (&other == &f ? 1 : 0));
  }
}
