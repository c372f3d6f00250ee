#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "host/store/store.h"
#include "tests/system/program.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;

namespace {

const char* const one_angle_plan = "angles_deg = [60]\nrepeats = 1\n";

double touch_of(const host::Store& store, const std::string& identity) {
  for (const auto& c : store.campaigns()) {
    if (c.rig_identity != identity) continue;
    const auto shots = store.shots(c.id, host::ShotKind::simulated);
    REQUIRE(shots.size() == 1);
    const auto events = store.load_events(shots[0].id);
    REQUIRE(events.has_value());
    return events->contact_voltage.contacts.at(0).touch.value;
  }
  FAIL("no campaign '" << identity << "'");
  return 0;
}

}  // namespace

TEST_CASE("a scene by name and by accuracy: said, run through the sensors, stored apart", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.plan.toml", one_angle_plan), db = folder.file("a.db");
  const auto told = run(folder, {"sim", plan, "--db", db, "--progress", "none"});
  REQUIRE(told.status == 0);
  CHECK_THAT(told.err, Contains("touch ms") && Contains("60 degrees") && Contains("events agree") &&
                           Contains("computable") && Contains("condition"));
  const auto modal =
      run(folder, {"sim", plan, "--db", db, "--mechanics", "modal", "--json", "--progress", "none"});
  REQUIRE(modal.status == 0);
  const auto j = nlohmann::json::parse(modal.out);
  CHECK(j["models"]["rung"] == "circuit+modal");
  CHECK(j["models"]["verdict"].is_null());  // a model by name: no accuracy was asked for
  CHECK(j["simulated"] == 1);
  CHECK(j["bounces"].empty());  // it takes steps: said so
  CHECK_THAT(modal.err, Contains("circuit+modal can be believed is not judged"));
  CHECK_THAT(modal.err, Contains("taken: circuit+modal"));
  const auto by_accuracy = run(folder, {"sim", plan, "--db", db, "--accuracy", "1%", "--progress", "none"});
  CHECK(by_accuracy.status == 7);
  CHECK_THAT(by_accuracy.err, Contains("taken: circuit+plant") && Contains("60 degrees") &&
                                  Contains("wanted accuracy: not known") &&
                                  Contains("touch: error of the fields, nothing to compare circuit with"));

  const host::Store store(db, host::Store::Mode::read_only);
  CHECK(store.campaigns().size() == 3);
  const double plain = touch_of(store, "simulation only"),
               bending = touch_of(store, "simulation by circuit+modal, step " +
                                             nlohmann::json(j["models"]["setting"]).dump());
  CHECK(bending == Approx(plain).margin(20e-6));
  // the same wish again finds what it stored
  const auto again =
      run(folder, {"sim", plan, "--db", db, "--mechanics", "modal", "--json", "--progress", "none"});
  CHECK(nlohmann::json::parse(again.out)["simulated"] == 0);
}

TEST_CASE("wishes that cannot be granted are refused with what is allowed", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.plan.toml", one_angle_plan), db = folder.file("a.db");
  const auto status = [&](std::vector<std::string> more, const char* says) {
    std::vector<std::string> arguments{"sim", plan, "--db", db, "--progress", "none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto r = run(folder, arguments);
    CHECK_THAT(r.err, Contains(says));
    return r.status;
  };
  CHECK(status({"--mechanics", "elastic"}, "plant, rigid, modal, explicit") == 2);
  CHECK(status({"--fields", "field4d"}, "circuit, table, field2d, field3d") == 2);
  CHECK(status({"--accuracy", "many"}, "--accuracy = many") == 2);
  const std::string wrong =
      folder.write("w.plan.toml", std::string(one_angle_plan) + "[wanted]\nfields = \"tabel\"\n");
  const auto r = run(folder, {"sim", wrong, "--db", db, "--progress", "none"});
  CHECK(r.status == 2);
  CHECK_THAT(r.err, Contains("wanted") && Contains("tabel") && Contains("table"));
}
