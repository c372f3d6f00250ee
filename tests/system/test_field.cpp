// `powbench field`: cores of two legs, what it tells, what it refuses.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "host/store/field_table.h"
#include "tests/end_ring.h"
#include "tests/system/program.h"

using namespace powbench::test;
using Catch::Contains;

TEST_CASE("a U- and a C-core: table, pictures, and how much of it rests on extrapolated steel", "[system]") {
  Folder folder;
  const std::string shape = "[shape]\nlegs = 2\nring_share = 0.0\nouter_width_mm = 12.0\nyoke_mm = 12.0\n";
  for (const char* leg : {"closed_leg = 0\n", "closed_leg = 1\n"}) {
    const std::string file = folder.write("two.specimen.toml", shape + leg);
    const Finished r = run(folder, {"field", file, "-o", folder.file("field"), "--accuracy", "5%"});
    INFO(r.err);
    CHECK(r.status == 0);
    CHECK_THAT(r.out, Contains("built") && Contains("steel up to") &&
                          Contains("above the B-H data, which end at 2.37 T"));
    CHECK_THAT(r.out, Contains("field-half.svg") && Contains("field-table.svg"));
    const Finished again =
        run(folder, {"field", file, "-o", folder.file("field"), "--accuracy", "5%", "--json"});
    CHECK_THAT(again.out, Contains("\"reused\": true") && Contains("\"states_beyond_data\": 0."));
  }
}

TEST_CASE("fields that cannot be: exit 2 and a sentence with key, value and range", "[system]") {
  Folder folder;
  const auto refused = [&](const std::string& text, std::vector<std::string> more = {}) {
    std::vector<std::string> words{"field", folder.write("x.specimen.toml", text), "-o",
                                   folder.file("field")};
    words.insert(words.end(), more.begin(), more.end());
    const Finished r = run(folder, words);
    CHECK(r.status == 2);
    CHECK(r.out.empty());
    return r.err;
  };
  CHECK_THAT(refused("[shape]\nlegs = 4\n"),
             Contains("x.specimen.toml:2") && Contains("legs = 4") && Contains("2..3"));
  CHECK_THAT(refused("[shape]\nclosed_leg = 1\n"), Contains("closed_leg = 1") && Contains("allowed 0"));
  CHECK_THAT(refused("[shape]\nlegs = 2\nclosed_leg = 1\n"),
             Contains("ring_share") && Contains("no pole face"));
  CHECK_THAT(refused("[shape]\nstack_mm = 0.018\n"), Contains("stack_mm = 0.018") && Contains("1..300"));
  CHECK_THAT(refused("[shape]\ncoil_width_mm = 12\n"), Contains("coil_width_mm") && Contains("up to 9"));
  CHECK_THAT(refused("[shape]\nring_slot_mm = 5\n"),
             Contains("ring_slot_mm") && Contains("the pole around the ring"));
  CHECK_THAT(refused("[magnet]\nresidual_gap_um = -1\n"), Contains("residual_gap_um = -1"));
  CHECK_THAT(refused("", {"--steel", "cheese"}), Contains("'cheese' is unknown") && Contains("lamination"));
}

TEST_CASE("a C-core with --ends: a table that needs less current for its flux than the plane one",
          "[system][.slow]") {
  Folder folder;
  // its edges on few planes, so that few cells hold it; its 196 states take 20 s of processor all the same
  const std::string file = folder.write(
      "c.specimen.toml",
      "[core]\ntravel_mm = 0.2\n[bridges]\ngap_mm = 0.1\n[shape]\nlegs = 2\nclosed_leg = 1\nring_share = "
      "0.0\n"
      "outer_width_mm = 8.0\ncoil_width_mm = 9.0\ncoil_offset_mm = 0.0\ncoil_height_mm = 16.9999\n");
  const auto table = [&](const char* ends) {
    std::vector<std::string> words{"field", file, "-o", folder.file("field"), "--accuracy", "5%", "--json"};
    if (*ends != 0) words.emplace_back(ends);
    const Finished r = run(folder, words);
    INFO(r.err);
    REQUIRE(r.status == 0);
    const auto said = nlohmann::json::parse(r.out)["table"].get<std::string>();
    return powbench::sim::TablePotential(powbench::host::load_field_table(said));
  };
  const auto ends = table("--ends"), plane = table("");
  for (const double psi : {0.1, 0.4})
    for (const double gap : {0.05e-3, 0.3e-3})
      CHECK(ends.at({psi, 0, gap}).current < plane.at({psi, 0, gap}).current);
}

TEST_CASE("a small core with --ends and --ring: table, pictures, and what ends and ring must do",
          "[system][.long]") {
  Folder folder;
  // its edges on few planes, so that few cells hold it; its 1764 states take two minutes of processor all the same
  const std::string file =
      folder.write("little.specimen.toml",
                   "[core]\ntravel_mm = 0.2\n[bridges]\ngap_mm = 0.1\n"
                   "[shape]\ncoil_width_mm = 9.0\ncoil_offset_mm = 0.0\ncoil_height_mm = 13.9999\n");
  const auto table = [&](std::vector<std::string> more, const char* accuracy = "5%") {
    std::vector<std::string> words{"field",      file,     "-o",     folder.file("field"),
                                   "--accuracy", accuracy, "--ring", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished r = run(folder, words);
    INFO(r.err);
    REQUIRE(r.status == 0);
    return nlohmann::json::parse(r.out);
  };
  const auto ends = table({"--ends"}), plane = table({}, "10%");  // 8.6 %: a gap of 0.2 mm needs more nodes
  CHECK_THAT(ends["description"].get<std::string>(), Contains("with ends"));
  CHECK(ends["reused"] == false);
  CHECK(ends["table"] != plane["table"]);
  CHECK(ends["accuracy_met"] == true);
  for (const auto& picture : ends["pictures"]) CHECK(read_file(picture.get<std::string>()).size() > 1000);
  const auto loaded = [](const nlohmann::json& j) {
    return powbench::sim::TablePotential(powbench::host::load_field_table(j["table"].get<std::string>()));
  };
  check_ends_with_ring(loaded(ends), loaded(plane));
  CHECK(table({"--ends"})["reused"] == true);
}
