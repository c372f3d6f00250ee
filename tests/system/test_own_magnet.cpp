// A magnet of one's own: drawing and specimen on the command line, what is refused and with which words. The page
// that leads there runs in test_tutorial.cpp.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>

#include "tests/places.h"
#include "tests/system/program.h"

using namespace powbench::test;
using Catch::Contains;

namespace {

const std::string examples = powbench::test::source_dir() + "/docs/examples/own-magnet";

/// The examples in a folder of their own.
struct Examples {
  Folder folder;
  Examples() {
    for (const auto& file : std::filesystem::directory_iterator(examples))
      std::filesystem::copy(file.path(), folder.file(file.path().filename().string()));
  }
  std::string file(const std::string& name) const { return folder.file(name); }

  /// What is said of a drawing in which one text stands for another.
  std::string refusal(const std::string& name, const std::string& what, const std::string& by,
                      std::vector<std::string> more = {}) const {
    std::string text = read_file(file(name));
    const auto at = text.find(what);
    REQUIRE(at != std::string::npos);
    text.replace(at, what.size(), by);
    std::vector<std::string> words{"field", folder.write("x.magnet.toml", text), "-o", file("out")};
    words.insert(words.end(), more.begin(), more.end());
    const Finished r = run(folder, words);
    CHECK(r.status == 2);
    CHECK(r.out.empty());
    return r.err;
  }
};

}  // namespace

TEST_CASE("own magnet: a half, a whole with ring, and one around an axis give table and pictures",
          "[system][.slow]") {
  const Examples e;
  for (const char* name : {"e-core", "u-core", "pot"}) {
    const Finished r = run(e.folder, {"field", e.file(std::string(name) + ".magnet.toml"), "-o",
                                      e.file("out"), "--accuracy", "5%", "--json"});
    INFO(r.err);
    REQUIRE(r.status == 0);
    const auto j = nlohmann::json::parse(r.out);
    CHECK(j["mesh_error"] < 1.66 * 0.03);  // 0.03: what one halving changes
    CHECK(j["largest_field_T"] > 1.8);
    double before = 0;
    for (const auto& state : j["states"]) {
      CHECK(state["pull_N"] > before);
      before = state["pull_N"];
    }
    for (const auto& file : j["pictures"]) CHECK(std::filesystem::file_size(file.get<std::string>()) > 1000);
  }
  const Finished ring = run(e.folder, {"field", e.file("e-core.magnet.toml"), "-o", e.file("out"), "--ring"});
  CHECK(ring.status == 2);
  CHECK_THAT(ring.err, Contains("--ring") && Contains("role ring"));
}

TEST_CASE("own magnet: a table with ring keeps what is asked of it, or says that it does not",
          "[system][.slow]") {
  const Examples e;
  const Finished r = run(
      e.folder, {"field", e.file("u-core.magnet.toml"), "-o", e.file("out"), "--accuracy", "5%", "--ring"});
  INFO(r.err << r.out);
  CHECK(r.status == 0);
  CHECK_THAT(r.out, Contains("18 x 12 x 18 nodes") && !Contains("MISSED"));
  const Finished fine = run(e.folder, {"field", e.file("u-core.magnet.toml"), "-o", e.file("out"),
                                       "--accuracy", "1%", "--ring", "--json"});
  CHECK(fine.status == 1);  // the mesh; the nodes keep it
  const auto j = nlohmann::json::parse(fine.out);
  CHECK(j["mesh_error"] > 0.01);
  CHECK(j["worst_current_error"] < 0.01);
  CHECK(j["worst_pull_error"] < 0.01);
  CHECK(j["accuracy_met"] == false);
}

TEST_CASE("own magnet: where no end of the flux is stated, a drawing has one that its table bears",
          "[system][.slow]") {
  const Examples e;
  std::string pot = read_file(e.file("pot.magnet.toml")), core = read_file(e.file("e-core.magnet.toml"));
  const auto without = [](std::string text, const std::string& key) {
    const auto at = text.find("\n" + key);
    REQUIRE(at != std::string::npos);
    return text.erase(at, text.find('\n', at + 1) - at);
  };
  e.folder.write("bare.magnet.toml", without(pot, "largest_flux_Wb"));
  for (const char* key : {"depth_mm", "stack_factor", "symmetry"}) core = without(core, key);
  core.replace(core.find("\"plane\""), 7, "\"axisymmetric\"");
  e.folder.write("round.magnet.toml", core);
  for (const char* name : {"bare", "round"})
    for (const char* accuracy : {"5%", "1%"}) {
      const Finished r = run(e.folder, {"field", e.file(std::string(name) + ".magnet.toml"), "-o",
                                        e.file("out"), "--accuracy", accuracy, "--json"});
      INFO(r.err);
      CHECK(r.status < 2);
      const auto j = nlohmann::json::parse(r.out);
      CHECK(j["largest_field_T"] < 2.6);
      CHECK(j["states_beyond_data"] < 0.4);
      CHECK(j["worst_current_error"] <= (std::string(accuracy) == "5%" ? 0.05 : 0.01));
    }
}

TEST_CASE("own magnet: nodes are added until a table keeps what is asked of it", "[system][.slow]") {
  // far into saturation most cells are of no use, and with the 15 nodes of 5 % the current falls with the flux
  const Examples e;
  std::string text = read_file(e.file("e-core.magnet.toml"));
  e.folder.write("far.magnet.toml", text.insert(text.find("travel_mm"), "largest_flux_Wb = 2.4\n"));
  const Finished far =
      run(e.folder, {"field", e.file("far.magnet.toml"), "-o", e.file("out"), "--accuracy", "5%"});
  INFO(far.out << far.err);
  CHECK(far.status == 0);
  CHECK_THAT(far.out, Contains("far, 22 x 1 x 15 nodes") || Contains("far, 33 x 1 x 15 nodes"));
  const Finished large = run(e.folder, {"field", e.file("pot.magnet.toml"), "-o", e.file("out"), "--accuracy",
                                        "5%", "--out", e.file("t.csv"), "--largest-current", "500"});
  CHECK(large.status == 2);
  CHECK_THAT(large.err, Contains("--largest-current = 500, allowed up to"));
}

TEST_CASE("own magnet: a closing outside of its table, and one that never moves, say so", "[system][.slow]") {
  const Examples e;
  const std::string low = e.refusal("pot.magnet.toml", "largest_flux_Wb = 0.6", "largest_flux_Wb = 60");
  CHECK_THAT(low, Contains("largest_flux_Wb = 60, allowed"));
  std::string text = read_file(e.file("pot.magnet.toml"));
  text.replace(text.find("= 0.6"), 5, "= 0.15");
  e.folder.write("low.magnet.toml", text);
  e.folder.write("low.specimen.toml",
                 "[magnet]\ndrawing = \"low.magnet.toml\"\n[coil]\nresistance_ohm = 245\n");
  const auto plan =
      e.folder.write("low.plan.toml", "specimen = \"low.specimen.toml\"\nangles_deg = [0]\nrepeats = 1\n");
  const std::vector<std::string> words{"sim",     plan,          "--db",       e.file("a.db"),
                                       "--cache", e.file("out"), "--progress", "none"};
  const Finished r = run(e.folder, words);
  INFO(r.err);
  CHECK(r.status == 1);
  CHECK_THAT(r.err, Contains("expected error: mesh") && Contains("exit code 1") &&
                        Contains("no contact closes") && !Contains("computable") &&
                        Contains("outside of what the fields were made from"));
  const Finished again = run(e.folder, words);  // kept, and no better for it
  CHECK(again.status == 1);
  CHECK_THAT(again.err, Contains("1 kept") && Contains("outside of what the fields were made from"));
  const Finished shown = run(e.folder, {"show", "1", "--db", e.file("a.db")});
  CHECK_THAT(shown.out, Contains("beyond_fields"));
  const Finished shots = run(e.folder, {"shots", "--db", e.file("a.db")});
  CHECK_THAT(shots.out, !Contains("360."));
}

TEST_CASE("own magnet: options that a drawing has no use for are refused, not ignored", "[system]") {
  const Examples e;
  for (const char* name : {"e-core", "relay"})
    for (const std::vector<std::string>& option : {std::vector<std::string>{"--steel", "m530-50a"},
                                                   {"--mesh", "e-core.msh"},
                                                   {"--current", "0.3"},
                                                   {"--mesh-unit", "m"},
                                                   {"--symmetric"},
                                                   {"--ends"}}) {
      std::vector<std::string> words{"field", e.file(std::string(name) + ".magnet.toml"), "-o",
                                     e.file("out")};
      words.insert(words.end(), option.begin(), option.end());
      const Finished r = run(e.folder, words);
      CHECK(r.status == 2);
      CHECK(r.out.empty());
      CHECK_THAT(r.err, Contains(option.front() + ": does not go with a drawing, "));
    }
  e.folder.write("x.specimen.toml", "[magnet]\ndrawing = \"e-core.magnet.toml\"\nsteel = \"my-steel.csv\"\n");
  const Finished r = run(e.folder, {"field", e.file("x.specimen.toml"), "-o", e.file("out")});
  CHECK(r.status == 2);
  CHECK_THAT(r.err,
             Contains("x.specimen.toml:3: [magnet] steel = \"my-steel.csv\": does not go with a drawing, "
                      "whose groups name their steels"));
}

TEST_CASE("own magnet: mistakes in a drawing end with one sentence: file, line, key, value, range",
          "[system]") {
  const Examples e;
  const auto with = [&](const std::string& what, const std::string& by) {
    return e.refusal("e-core.magnet.toml", what, by);
  };
  CHECK_THAT(with("\"e-core.msh\"", "\"none.msh\""),
             Contains("x.magnet.toml:2: mesh = \"none.msh\"") && Contains("cannot be read"));
  CHECK_THAT(with("[group.core]", "[group.cor]"),
             Contains("unknown section") && Contains("core") &&
                 Contains("[group.core] role: is missing: the mesh has this surface"));
  const auto anker = with("[group.armature]", "[group.Anker]");
  CHECK_THAT(anker,
             Contains("[group.Anker]: unknown section; the mesh has rim, core, armature, coil, layer, air; "
                      "without a section: armature\n"));
  CHECK_THAT(anker, !Contains("did you mean"));
  CHECK_THAT(with("[group.armature]", "[group.armatur]"),
             Contains("; without a section: armature; did you mean 'group.armature'?"));
  CHECK_THAT(with("role = \"armature\"", "role = \"anchor\""),
             Contains("no such word") && Contains("\"armature\", \"coil\""));
  CHECK_THAT(with("unit = \"mm\"", "unit = \"m\""),
             Contains("unit = \"m\": the mesh is 2.2e+05 mm wide or high; in mm it would be 220 mm"));
  CHECK_THAT(with("drawn_gap_mm = 1.5", "drawn_gap_mm = 1.6"),
             Contains("drawn_gap_mm = 1.6: the faces of the mesh are 1.5 mm apart"));
  CHECK_THAT(with("opening = \"+y\"", "opening = \"-y\""),
             Contains("opening = \"-y\"") && Contains("no fixed iron to close on"));
  CHECK_THAT(with("role = \"stretch\"", "role = \"air\""),
             Contains("the armature is joined to the fixed iron 'core' by 'air', 'layer'"));
  CHECK_THAT(with("turns = 2000", "turns = 0"), Contains("[group.coil] turns = 0: carry no current"));
  CHECK_THAT(with("symmetry = \"half\"", "symmetry = \"whole\""), Contains("leave 2000 over"));
  CHECK_THAT(with("steel = \"m530-50a\"", "steel = \"cheese\""),
             Contains("[group.armature] steel = \"cheese\"") && Contains("unknown"));
  CHECK_THAT(with("steel = \"m530-50a\"", ""), Contains("[group.armature] steel: is missing"));
  CHECK_THAT(with("role = \"A=0\"", "role = \"none\""),
             Contains("no line has the role A=0") && Contains("rim"));
  CHECK_THAT(with("depth_mm = 20", ""), Contains("depth_mm: is missing"));
  CHECK_THAT(e.refusal("pot.magnet.toml", "opening = \"+y\"", "opening = \"+x\""),
             Contains("is across the axis"));
  CHECK_THAT(e.refusal("u-core.magnet.toml", "turns = -1\n", "turns = 1\n"), Contains("leave 2 over"));
  CHECK_THAT(e.refusal("u-core.magnet.toml", "turns = -1\n", "turns = 2\n"), Contains("a ring is one turn"));
}

TEST_CASE("own magnet: mistakes in a drawing in space end with one sentence: file, line, key, value, range",
          "[system]") {
  const Examples e;
  const auto with = [&](const std::string& what, const std::string& by) {
    return e.refusal("relay.magnet.toml", what, by);
  };
  CHECK_THAT(with("\"relay.msh\"", "\"none.msh\""),
             Contains("x.magnet.toml:2: mesh = \"none.msh\"") && Contains("cannot be read"));
  CHECK_THAT(with("\"relay.msh\"", "\"e-core.msh\""),
             Contains("mesh = \"e-core.msh\"") && Contains("has no physical volume"));
  CHECK_THAT(with("kind = \"space\"", "kind = \"spase\""),
             Contains("no such word") && Contains("\"plane\", \"axisymmetric\", \"space\""));
  CHECK_THAT(
      with("[group.hinge]", "[group.hing]"),
      Contains("unknown section") && Contains("[group.hinge] role: is missing: the mesh has this volume"));
  CHECK_THAT(
      with("[group.hinge]", "[group.Gelenk]"),
      Contains("unknown section; the mesh has core, armature, hinge, coil, bobbin, air; without a section: "
               "hinge\n"));
  CHECK_THAT(with("unit = \"mm\"", "unit = \"m\""),
             Contains("unit = \"m\"") && Contains("in mm it would be"));
  CHECK_THAT(with("drawn_gap_mm = 1.0", "drawn_gap_mm = 1.2"),
             Contains("drawn_gap_mm = 1.2: the faces of the mesh are 1 mm apart"));
  CHECK_THAT(with("opening = \"+z\"", "opening = \"-z\""),
             Contains("opening = \"-z\"") && Contains("no fixed iron to close on"));
  CHECK_THAT(with("mirror = \"y\"", "mirror = \"x\""),
             Contains("mirror = \"x\"") && Contains("so that x = 0 is no end of it"));
  CHECK_THAT(with("mirror = \"y\"", "mirror = \"yz\""),
             Contains("the armature moves across a plane of symmetry"));
  CHECK_THAT(with("mirror = \"y\"", "mirror = \"none\""), Contains("leaves no opening in the group's box"));
  CHECK_THAT(with("width_mm = 10", "width_mm = 8"), Contains("a winding of this width and corner"));
  CHECK_THAT(with("width_mm = 10", "width_mm = 100"),
             Contains("width_mm = 100: leaves no opening in the group's box; allowed 0.01..17 mm"));
  CHECK_THAT(with("width_mm = 10", ""), Contains("[group.coil] width_mm: is missing"));
  CHECK_THAT(with("axis = \"z\"", "axis = \"y\""), Contains("axis = \"y\": stands on a plane of symmetry"));
  CHECK_THAT(with("turns = 3000", "turns = 0"), Contains("[group.coil] turns = 0: carry no current"));
  CHECK_THAT(with("role = \"air\"", "role = \"stretch\""),
             Contains("'bobbin' reaches into its opening, and moves or stretches"));
  CHECK_THAT(with("role = \"stretch\"             # the leg", "role = \"fixed\"             # the leg"),
             Contains("the armature is joined to the fixed iron"));
  CHECK_THAT(with("mirror = \"y\"", "mirror = \"y\"\nstack_factor = 0.9"),
             Contains("stack_factor = 0.9: is of sheets"));
}

TEST_CASE("own magnet: a specimen names its drawing; the circuit stands aside until it is stated",
          "[system][.slow]") {
  const Examples e;
  const std::string plan = e.folder.write(
      "one.plan.toml", "specimen = \"e-core.specimen.toml\"\nangles_deg = [60]\nrepeats = 1\n");
  const auto simulated = [&](std::vector<std::string> more = {}) {
    std::vector<std::string> words{"sim",     plan,          "--db",       e.file("a.db"),
                                   "--cache", e.file("out"), "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    return run(e.folder, words);
  };
  const auto table = simulated({"--json"});
  INFO(table.err);
  REQUIRE(table.status == 0);
  CHECK_THAT(table.err, Contains("a drawing and no circuit: fields = table"));
  const auto j = nlohmann::json::parse(table.out);
  CHECK(j["models"]["rung"] == "table+rigid");
  CHECK(j["states_beyond_fields"] == 0.0);
  const auto circuit = simulated({"--fields", "circuit"});
  CHECK(circuit.status == 2);
  CHECK_THAT(circuit.err, Contains("pole_area_mm2 and iron_length_mm"));

  const auto refused = [&](const std::string& lines) {
    e.folder.write("x.specimen.toml", lines);
    const auto r = run(e.folder, {"field", e.file("x.specimen.toml"), "-o", e.file("out")});
    CHECK(r.status == 2);
    return r.err;
  };
  const std::string drawing = "[magnet]\ndrawing = \"e-core.magnet.toml\"\n";
  CHECK_THAT(refused("[coil]\nturns = 1000\n" + drawing),
             Contains("turns = 1000: the drawing has another value"));
  CHECK_THAT(refused(drawing + "[shape]\nlegs = 3\n"), Contains("[shape] is another magnet"));
  CHECK_THAT(refused(drawing + "fringing = 0.3\n"), Contains("is of a lumped circuit"));
  CHECK_THAT(refused("[magnet]\ndrawing = \"none.magnet.toml\"\n"),
             Contains("none.magnet.toml") && Contains("cannot be read"));
}
