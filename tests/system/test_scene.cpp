#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "host/store/store.h"
#include "tests/places.h"
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

TEST_CASE("an accuracy is judged at every angle of a plan, whatever their order", "[system]") {
  Folder folder;
  nlohmann::json before;
  for (const char* angles : {"[0, 60, 90]", "[90, 0, 60]"}) {
    const std::string plan = folder.write("p.plan.toml", std::string("repeats = 1\nangles_deg = ") + angles);
    const auto r = run(folder, {"sim", plan, "--db", folder.file("a.db"), "--accuracy", "1%", "--json",
                                "--progress", "none"});
    INFO(angles << "\n" << r.err);
    CHECK(r.status == 7);
    CHECK_THAT(r.err, Contains("where it is furthest from what is wanted") &&
                          Contains("by closing angle, degrees: not known at 0 60 90"));
    auto models = nlohmann::json::parse(r.out)["models"];
    REQUIRE(models["by_angle"].size() == 3);
    double share = 0;
    for (const auto& a : models["by_angle"]) share = std::max(share, a["share"].get<double>());
    for (const auto& a : models["by_angle"])
      if (a["share"] == share) CHECK(a["angle_deg"] == models["angle_deg"]);
    for (const char* clock : {"cpu_ms_with_choosing", "looked_at"}) models.erase(clock);
    if (!before.is_null()) CHECK(models == before);
    before = models;
  }
}

TEST_CASE("closings that were only simulated are not judged, and nothing of them is missing", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.plan.toml", "angles_deg = [0, 60]\nrepeats = 2\n"),
                    db = folder.file("a.db");
  REQUIRE(run(folder, {"sim", plan, "--db", db, "--progress", "none"}).status == 0);
  CHECK(run(folder, {"compare", "--db", db}).status == 0);
  const auto r = run(folder, {"report", "--db", db, "-o", folder.file("out"), "--json"});
  CHECK(r.status == 0);
  const auto summary = nlohmann::json::parse(r.out);
  CHECK(summary["verdict"] == "NOT JUDGED");
  CHECK(read_file(folder.file("out/junit.xml")).find("skipped=\"1\"") != std::string::npos);
  CHECK_THAT(read_file(folder.file("out/report.html")), Contains("closings were only computed"));
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
  CHECK(status({"--mechanics", "elastic"}, "plant, rigid, modal, deformable") == 2);
  CHECK(status({"--fields", "field4d"}, "circuit, table, solved, ends, auto") == 2);
  CHECK(status({"--accuracy", "many"}, "--accuracy = many") == 2);
  const std::string wrong =
      folder.write("w.plan.toml", std::string(one_angle_plan) + "[wanted]\nfields = \"tabel\"\n");
  const auto r = run(folder, {"sim", wrong, "--db", db, "--progress", "none"});
  CHECK(r.status == 2);
  CHECK_THAT(r.err, Contains("wanted") && Contains("tabel") && Contains("table"));
  const std::string apart = folder.write(
      "x.plan.toml", std::string(one_angle_plan) + "[wanted]\nfields = \"table\"\nmechanics = \"plant\"\n");
  CHECK_THAT(run(folder, {"plan", "check", apart}).err,
             Contains("x.plan.toml:5") && Contains("fields = circuit"));
}

TEST_CASE("what the numbers of a specimen make together, beside catalogue ranges; a former file is converted",
          "[system]") {
  Folder folder;
  const auto text = run(folder, {"specimen", "describe"});
  REQUIRE(text.status == 0);
  CHECK_THAT(text.out, Contains("inrush, VA") && Contains("70 .. 230") && Contains("picks up at, V") &&
                           Contains("base on its mounting, Hz") && Contains("inside"));
  const std::string heavy =
      folder.write("a.specimen.toml", "[base]\nmode_Hz = 200\n[bridges]\nrate_N_per_m = 50000\n");
  const auto described = run(folder, {"specimen", "describe", heavy, "--json"});
  REQUIRE(described.status == 0);
  const auto numbers = nlohmann::json::parse(described.out)["numbers"];
  CHECK(numbers["base_Hz"]["value"] == 200);
  // 0.5 (3.07 + 50000 (4.06e-3 - 2.5e-3)) N
  CHECK(numbers["break_force_N"]["value"].get<double>() == Approx(40.535));
  CHECK(numbers["break_force_N"]["verdict"] == "outside");
  // the key that is a digit off is named too, in its own unit
  CHECK(numbers["bridges.rate_N_per_m"]["value"] == 50000);
  CHECK(numbers["bridges.rate_N_per_m"]["catalogue_high"] == 6000);
  CHECK(numbers["bridges.rate_N_per_m"]["note"] == "");  // a spring that stiff has no explanation but a slip
  CHECK_FALSE(numbers.contains("core.mass_g"));
  // of another device than the catalogues', with pads: each of its seven keys outside says what it may mean
  const auto pads = nlohmann::json::parse(
      run(folder, {"specimen", "describe", source_dir() + "/scenes/contact-pressure.specimen.toml", "--json"})
          .out);
  int outside = 0;
  for (const auto& [key, fact] : pads["numbers"].items())
    if (key.find('.') != std::string::npos) {
      CAPTURE(key);
      CHECK(fact["verdict"] == "outside");
      CHECK_FALSE(fact["note"].get<std::string>().empty());
      ++outside;
    }
  CHECK(outside == 7);
  CHECK_THAT(pads["numbers"]["bridges.contact_stiffness_N_per_m"]["note"].get<std::string>(),
             Contains("softer than metal on metal"));
  // kilograms where grams are asked for
  const auto kilograms =
      run(folder, {"specimen", "describe", folder.write("kg.specimen.toml", "[core]\nmass_g = 0.15\n")});
  CHECK(kilograms.status == 2);
  CHECK_THAT(kilograms.err, Contains("mass_g = 0.15") && Contains("5..20000"));
  // sqrt(k / m) / 2 pi of 50 kN/m and 7.76 g
  CHECK(numbers["bridge_Hz"]["value"].get<double>() == Approx(403.99).epsilon(1e-4));
  const std::string former = folder.write(
      "b.specimen.toml",
      "[core]\nstop_restitution = 0.1\n[bridges]\ncontact_restitution = 0.465\nseat_damping = 0.1\n");
  const auto now = run(folder, {"specimen", "convert", former});
  REQUIRE(now.status == 0);
  CHECK_THAT(now.out, Contains("stop_restitution = 0.13126") && Contains("contact_restitution = 0.51133") &&
                          Contains("seat_damping = 0.101926"));
  const auto twice = run(folder, {"specimen", "convert", folder.write("c.specimen.toml", now.out)});
  CHECK(twice.status == 2);
  CHECK_THAT(twice.err, Contains("c.specimen.toml:1: is converted already"));
  const auto wrong = run(folder, {"specimen", "describe", "nowhere.toml"});
  CHECK(wrong.status == 2);
  CHECK_THAT(run(folder, {"specimen", "describe", "--help"}).out,
             Contains("catalogue") && Contains("--volts"));
}

TEST_CASE("a ladder states three errors, and an accuracy of the step alone is not known", "[system]") {
  Folder folder;
  const auto all = run(folder, {"ladder", "--angle", "60", "-o", folder.file("l")});
  REQUIRE(all.status == 0);
  CHECK_THAT(all.out, Contains("three errors") && Contains("not known"));
  // one kind of fields: bending parts tell what rigid ones leave out, and nothing tells of the circuit
  const auto errors = nlohmann::json::parse(
      run(folder, {"ladder", "--angle", "60", "-o", folder.file("l"), "--json"}).out)["errors"];
  REQUIRE(errors[0]["rung"] == "circuit+plant");
  CHECK(errors[0]["model_error_s"][0].is_null());
  CHECK(errors[0]["model_error_known_part_s"][0].get<double>() > 1e-9);
  const auto chosen = run(folder, {"ladder", "--angle", "60", "--accuracy", "1%", "--json"});
  CHECK(chosen.status == 7);
  const auto j = nlohmann::json::parse(chosen.out);
  CHECK(j["verdict"] == "not known");
  CHECK(j["step_met"] == true);
  CHECK(j["model_error_s"][0].is_null());
  CHECK(j["input_error_s"][0].get<double>() > 1e-6);
}

TEST_CASE("a ladder judges every pair at every angle, against the measurement where there is one",
          "[system]") {
  Folder folder;
  const std::string specimen = source_dir() + "/scenes/published.specimen.toml",
                    fit = source_dir() + "/scenes/published.fit.json";
  const std::vector<std::string> words{"ladder",  specimen, "--mechanics", "rigid", "--judge", "5%",
                                       "--angle", "30",     "90",          "--fit", fit};
  const auto text = run(folder, words);
  REQUIRE(text.status == 0);
  CHECK_THAT(text.out,
             Contains("measured") && Contains("verdict") && Contains("of 2 angles and 3 times each"));
  auto as_json = words;
  as_json.emplace_back("--json");
  const auto j = nlohmann::json::parse(run(folder, as_json).out);
  REQUIRE(j["angles"].size() == 2);
  const auto& first = j["angles"][0];
  CHECK(first["measured_s"][0].get<double>() == Approx(11.86e-3).margin(1e-9));  // table 2 of the paper
  const auto& pair = first["pairs"][0];
  CHECK(pair["rung"] == "circuit+rigid");
  // no verdict without evidence: nothing tells the error of rigid parts here
  CHECK(pair["verdicts"] == nlohmann::json({"not known", "not known", "not known"}));
  CHECK(pair["field_error_s"][0].get<double>() >=
        std::abs(pair["times_s"][0].get<double>() - first["measured_s"][0].get<double>()));
  // the core row of 90 degrees is impossible as printed, so nothing is known of the seat
  CHECK(j["angles"][1]["measured_s"][1].is_null());
  CHECK(j["angles"][1]["pairs"][0]["field_error_s"][1].is_null());
  // measured at 20 degC: it says nothing of a hot coil
  auto hot = as_json;
  hot.insert(hot.end(), {"--ambient", "60"});
  const auto other = nlohmann::json::parse(run(folder, hot).out);
  CHECK(other["angles"][0]["measured_s"][0].is_null());
  CHECK(other["angles"][0]["pairs"][0]["field_error_s"][0].is_null());
}
