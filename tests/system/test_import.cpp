#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/system/program.h"

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

namespace {

const char* const pulse_file =
    "time [ms],pvdf_a "
    "[mN]\n-1,0\n-0.9,10\n-0.8,0\n-0.7,-10\n-0.6,0\n-0.5,10\n-0.4,0\n-0.3,0\n-0.2,0\n-0.1,0\n0,0\n";

}  // namespace

TEST_CASE("a shot of the simulated rig: export, import, events: the same times", "[system]") {
  Folder folder;
  const std::string db = folder.file("a.db"), csv = folder.file("shot.csv");
  const std::string plan = folder.write("p.toml", "angles_deg = [60]\nrepeats = 1\n");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--progress", "none"}).status == 0);
  REQUIRE(run(folder, {"export", "1", "--db", db, "-o", csv}).status == 0);
  REQUIRE(std::filesystem::exists(folder.file("shot.toml")));
  const json before = json::parse(run(folder, {"events", "1", "--db", db, "--json"}).out);
  const Finished direct = run(folder, {"events", csv, "--json"});
  REQUIRE(direct.status == 0);
  const json after = json::parse(direct.out);
  for (const char* channel : {"pvdf_a", "pvdf_b"}) {
    const json &a = before[channel]["contacts"], &b = after["channels"][channel]["contacts"];
    REQUIRE(a.size() >= 2);
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
      CHECK(std::abs(a[i]["touch_s"]["value"].get<double>() - b[i]["touch_s"].get<double>()) < 0.1e-6);
  }
  CHECK(std::abs(before["core"]["seat_s"]["value"].get<double>() - after["core"]["seat_s"].get<double>()) <
        0.1e-6);
  CHECK(after["closing_angle_deg"].get<double>() == Approx(60).margin(0.5));
  // a stored shot has what programs read of a file under the same keys
  CHECK(before["channels"]["pvdf_a"]["contacts"].size() == after["channels"]["pvdf_a"]["contacts"].size());
  CHECK(before["channels"]["pvdf_a"]["contacts"][0]["touch_s"] ==
        before["pvdf_a"]["contacts"][0]["touch_s"]["value"]);
  CHECK(before["closing_angle_deg"].get<double>() ==
        Approx(after["closing_angle_deg"].get<double>()).margin(0.01));
  CHECK(after["core"]["resolution_s"].get<double>() == Approx(400e-6));
  REQUIRE(after["bands"].size() == 2);
  CHECK(after["bands"][0]["film"] == "pvdf_a");
  CHECK(after["bands"][0]["modes_hertz"].size() == before["bands"][0]["modes_hertz"].size());

  const Finished people = run(folder, {"events", csv});
  CHECK_THAT(people.out, Contains("film A: ") && Contains("re-openings"));
  CHECK_THAT(people.out, Contains(" us  release "));  // uncertainties in us: in ms they would read zero
  CHECK_THAT(people.out, !Contains("+- 0.000"));
  CHECK((people.out.find("core vibrates at") != std::string::npos ||
         people.out.find("no core vibration stands out") != std::string::npos));
  CHECK(before["pole"]["by_force"]["present"].get<bool>());
  CHECK_FALSE(before["pole"]["by_force"]["contacts"].empty());
  CHECK(before["pole"]["longest_disagreement_s"]["value"].get<double>() <=
        before["pole"]["disagreement_s"]["value"].get<double>());
  CHECK(before["pvdf_a"]["first_train"]["openings"].get<int>() +
            before["pvdf_a"]["second_train"]["openings"].get<int>() ==
        before["pvdf_a"]["bounce_count"].get<int>());
  const Finished by_id = run(folder, {"events", "1", "--db", db});
  CHECK_THAT(by_id.out, Contains("pole by force: ") && Contains("first train: ") &&
                            Contains("force and contact voltage differ for "));
  double before_level = 0;
  for (const char* percent : {"10", "50", "90"}) {
    const Finished lab =
        run(folder, {"events", csv, "--force-percent", percent, "--min-opening-us", "20", "--json"});
    REQUIRE(lab.status == 0);
    const json crossings = json::parse(lab.out)["channels"]["pvdf_a"]["contacts"];
    REQUIRE_FALSE(crossings.empty());
    CHECK(crossings[0]["touch_s"].get<double>() > before_level);  // a higher level is crossed later
    before_level = crossings[0]["touch_s"].get<double>();
  }
  CHECK(run(folder, {"events", csv, "--force-percent", "120"}).status == 2);

  const Finished first = run(folder, {"import", csv, "--db", db}),
                 again = run(folder, {"import", csv, "--db", db});
  CHECK(first.status == 0);
  CHECK(first.out == "2\n");
  CHECK(again.out == "2\n");  // stored once
  CHECK_THAT(again.err, Contains("is already shot 2"));
  const json stored = json::parse(run(folder, {"events", "2", "--db", db, "--json"}).out);
  CHECK(stored["pvdf_a"] == json::parse(run(folder, {"events", "2", "--db", db, "--json"}).out)["pvdf_a"]);
  CHECK(std::abs(stored["pvdf_a"]["contacts"][0]["touch_s"]["value"].get<double>() -
                 before["pvdf_a"]["contacts"][0]["touch_s"]["value"].get<double>()) < 0.1e-6);
  CHECK(run(folder, {"report", "--db", db, "-o", folder.file("out")}).status == 0);
}

// Without the time that the coil is on, the opening at the end counted as one more bounce: no settled touch, no bounce
// time, and films whose zero came from behind the opening.
TEST_CASE("a record that contains the opening has its bounce time, or a sentence says what it needs",
          "[system]") {
  Folder folder;
  const std::string db = folder.file("a.db"), csv = folder.file("shot.csv"), rig = folder.file("rig.toml");
  folder.write("rig.toml", "record_length_ms = 240\npretrigger_ms = 40\n");
  const std::string plan = folder.write("p.toml", "angles_deg = [60]\nrepeats = 1\nhold_time_ms = 140\n");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:" + rig, "--db", db, "--progress", "none"}).status == 0);
  REQUIRE(run(folder, {"export", "1", "--db", db, "-o", csv}).status == 0);
  const json told = json::parse(run(folder, {"events", csv, "--json"}).out);
  const auto contacts = [](const json& e, const char* channel) { return e["channels"][channel]["contacts"]; };
  REQUIRE(told["channels"]["contact_a"]["bounce_time_s"].is_number());

  const std::string given = read_file(folder.file("shot.toml"));
  std::string unsaid = given;
  const std::size_t line = unsaid.find("hold_ms");
  REQUIRE(line != std::string::npos);
  unsaid.erase(line, unsaid.find('\n', line) - line);
  folder.write("shot.toml", unsaid);
  const Finished seen = run(folder, {"events", csv, "--json"});
  REQUIRE(seen.status == 0);
  CHECK_THAT(seen.err, Contains("the coil voltage ends 14") &&
                           Contains(" ms after switch-on: evaluated up to there, as with hold_ms = 14"));
  const json found = json::parse(seen.out);
  CHECK(found["channels"]["contact_a"]["bounce_time_s"] == told["channels"]["contact_a"]["bounce_time_s"]);
  for (const char* channel : {"contact_a", "pvdf_a", "pvdf_b"}) {
    REQUIRE_FALSE(contacts(found, channel).empty());
    CHECK(contacts(found, channel).size() == contacts(told, channel).size());
    CHECK(contacts(found, channel).back()["release_s"].is_null());
  }

  // without the mains the coil voltage gives the closing angle
  std::string rows = read_file(csv);
  rows.replace(rows.find("mains_voltage"), 3, "my_");
  folder.write("shot.csv", rows);
  folder.write("coil.toml", "[columns]\ncoil_voltage = \"coil_voltage\"\n");
  const Finished by_coil = run(folder, {"events", csv, "--calibration", folder.file("coil.toml"), "--json"});
  REQUIRE(by_coil.status == 0);
  const json angle = json::parse(by_coil.out);
  CHECK(angle["closing_angle_from"] == "coil_voltage");
  CHECK_FALSE(told.contains("closing_angle_from"));
  CHECK(
      std::abs(angle["closing_angle_deg"].get<double>() - told["closing_angle_deg"].get<double>()) <
      3 * std::hypot(angle["u_closing_angle_deg"].get<double>(), told["u_closing_angle_deg"].get<double>()));
  CHECK_THAT(run(folder, {"events", csv, "--calibration", folder.file("coil.toml")}).out,
             Contains("closing angle ") && Contains("from the coil voltage after switch-on"));

  // no channel of the coil: it is not known whether the contact was let go
  for (const char* name : {"coil_voltage", "coil_current", "laser"}) rows.replace(rows.find(name), 3, "my_");
  folder.write("shot.csv", rows);
  folder.write("bare.toml", "[columns]\ncontact_a = \"contact_a\"\n");
  const std::string bare = folder.file("bare.toml");
  for (const Finished& open : {run(folder, {"events", csv, "--calibration", bare}),
                               run(folder, {"import", csv, "--calibration", bare, "--db", db})}) {
    CHECK(open.status == 0);
    CHECK_THAT(open.err,
               Contains(" goes back to its rest at 1") &&
                   Contains(" ms: no settled touch. If the coil was switched off before, write hold_ms = 1"));
  }
  CHECK_THAT(run(folder, {"events", csv, "--calibration", bare}).out,
             Contains("no bounce time: the contact opens at 14") && Contains(" ms and stays open"));
  const Finished followed = run(
      folder, {"events", csv, "--calibration",
               folder.write("held.toml", "hold_ms = 140\n[columns]\ncontact_a = \"contact_a\"\n"), "--json"});
  CHECK(json::parse(followed.out)["channels"]["contact_a"]["bounce_time_s"].is_number());
  CHECK_THAT(followed.err, !Contains("hold_ms"));
}

TEST_CASE("the plan's filter: stored with the campaign, found again, refused where it would eat bounces",
          "[system]") {
  Folder folder;
  const std::string db = folder.file("a.db");
  const auto fired = [&](const char* filter) {
    const std::string plan = folder.write(
        "p.toml", std::string("angles_deg = [60]\nrepeats = 1\n[events]\nfilter = \"") + filter + "\"\n");
    REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--progress", "none"}).status == 0);
  };
  fired("lowpass:40kHz");
  const json kept = json::parse(run(folder, {"show", "1", "--db", db, "--json"}).out)["events"];
  const json again = json::parse(run(folder, {"events", "1", "--db", db, "--json"}).out);
  CHECK(again["filter"]["applied"].get<bool>());
  CHECK(again["filter"]["films"].size() == 2);
  CHECK(kept["pvdf_a"]["contacts"].size() >= 2);
  CHECK(kept["pvdf_a"] == again["pvdf_a"]);
  CHECK(kept["parameters_hash"] == again["parameters_hash"]);
  const json bare = json::parse(run(folder, {"events", "1", "--db", db, "--filter", "none", "--json"}).out);
  CHECK_FALSE(bare.contains("filter"));
  CHECK(bare["pvdf_a"] != again["pvdf_a"]);
  CHECK(bare["parameters_hash"] != again["parameters_hash"]);
  const Finished causal = run(folder, {"events", "1", "--db", db, "--phase", "causal"});
  CHECK_THAT(causal.out, Contains("low-pass 40 kHz causal; delay 2.8 us taken out of the times"));

  const std::string picture = folder.file("strip.svg");
  REQUIRE(run(folder, {"events", "1", "--db", db, "--picture", picture}).status == 0);
  const std::string drawn = read_file(picture);
  CHECK_THAT(drawn, Contains("SIMULATED RIG, measured shot 1, low-pass 40 kHz zero phase force") &&
                        Contains("film B / N") && Contains("frequency / kHz") && !Contains("nan"));
  REQUIRE(run(folder, {"events", "1", "--db", db, "--filter", "none", "--picture", picture}).status == 0);
  CHECK(read_file(picture) != drawn);
  CHECK(run(folder, {"events", "1", "--db", db, "--picture", "strip.png"}).status == 2);

  // the rig's bounces are a tenth of a millisecond: the shot is kept, without the filter
  fired("lowpass:2kHz");
  const Finished refused = run(folder, {"events", "2", "--db", db});
  CHECK(refused.status == 0);
  CHECK_THAT(refused.out,
             Contains("filter lowpass:2kHz refused, events without it: ") && Contains("a low-pass from"));
  CHECK(run(folder, {"events", "2", "--db", db, "--filter", "lowpass:2kHz"}).status == 2);
  const Finished narrow = run(folder, {"events", "1", "--db", db, "--band", "15kHz..18kHz", "--json"});
  REQUIRE(narrow.status == 0);
  const json bands = json::parse(narrow.out)["bands"];
  for (const json& film : bands)
    for (const json& hertz : film["modes_hertz"]) CHECK(hertz.get<double>() > 14e3);
}

TEST_CASE("a stranger's file without a database: events or one clear sentence", "[system]") {
  Folder folder;
  const Finished quiet = run(folder, {"events", folder.write("quiet.csv", pulse_file), "--json"});
  CHECK(quiet.status == 0);
  CHECK(json::parse(quiet.out)["channels"]["pvdf_a"]["contacts"].empty());
  CHECK_THAT(quiet.err, Contains("no calibration is named"));
  CHECK_FALSE(std::filesystem::exists(folder.file("powbench.db")));
  for (const auto& [text, sentence] : {std::pair{"", "empty"},
                                       {"time [s],pvdf_x [N]\n", "did you mean"},
                                       {"time [s],pvdf_a [V]\n0,1\n", "volts need"}}) {
    const Finished r = run(folder, {"events", folder.write("bad.csv", text), "--json"});
    CHECK(r.status == 2);
    CHECK(r.out.empty());
    CHECK_THAT(r.err, Contains("bad.csv:1") && Contains(sentence));
    CHECK(run(folder, {"import", folder.file("bad.csv"), "--db", folder.file("b.db")}).status == 2);
    CHECK_FALSE(std::filesystem::exists(folder.file("b.db")));
  }
  CHECK(run(folder, {"events", folder.file("none.csv")}).status == 2);
  CHECK_THAT(run(folder, {"import", folder.write("shot.xlsx", "PK\x03\x04 workbook")}).err,
             Contains("save the sheet as CSV"));
  CHECK_THAT(run(folder, {"import", folder.write("shot.bin", std::string("a\0b", 3))}).err,
             Contains("binary data") && Contains(".tdms"));
  std::string rows = "in s;Kontakt [V]\n";
  for (int i = 0; i < 100; ++i)
    rows += "0,0" + std::to_string(100 + i) + ";" + (i < 50 ? "6,0" : "0,0") + "\n";
  const std::string german = folder.write("german.csv", rows);
  const Finished suggested = run(folder, {"import", german, "--suggest", "-o", folder.file("german.toml")});
  CHECK_THAT(suggested.err, Contains("in s ") && Contains("time ") && Contains("contact_a"));
  const Finished german_events = run(folder, {"events", german});
  INFO(german_events.err);
  CHECK(german_events.status == 0);
  folder.write("german.toml", "[columns]\ncontact_a = \"Kontakt\"\n");  // `in s` is the time by itself
  CHECK(run(folder, {"events", german}).status == 0);
  folder.write("german.toml", "[columns]\ncontact_a = \"Kontakt\"\n[contact_a]\ngain_V_per_V = 0,1\n");
  CHECK_THAT(run(folder, {"events", german}).err,
             Contains("german.toml:4: not TOML") && Contains("write a decimal point"));
  CHECK(run(folder, {"events", folder.file("bad.csv"), "--calibration", folder.file("none.toml")}).status ==
        2);
  CHECK_THAT(run(folder, {"import", "--help"}).out,
             Contains("time [s],pvdf_a [N]") && Contains("gain_N_per_V"));
  CHECK_THAT(run(folder, {"plan", "template", "calibration"}).out,
             Contains("[pvdf_a]") && Contains("corner_hertz"));
}
