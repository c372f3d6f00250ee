#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "host/gather/scene.h"
#include "tests/system/program.h"

/// What a report may claim: nothing is passed without a limit, nothing unknown becomes a number, and everything says
/// where it comes from.

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

namespace {

json report(const Folder& folder, const std::string& db, int expected) {
  const Finished r = run(folder, {"report", "--db", db, "-o", folder.file("out"), "--json"});
  INFO(r.err);
  CHECK(r.status == expected);
  return json::parse(r.out);
}

}  // namespace

TEST_CASE("a plan without limits is NOT JUDGED everywhere, never a pass", "[system]") {
  Folder folder;
  const std::string db = folder.file("a.db");
  const std::string plan = folder.write("p.toml", "angles_deg = [60]\nrepeats = 1\n");
  const Finished fired = run(folder, {"run", plan, "--rig", "sim:", "--db", db});
  CHECK(fired.status == 0);
  CHECK_THAT(fired.err, Contains("1 NOT JUDGED") && !Contains("PASS"));
  CHECK(report(folder, db, 0).at("verdict") == "NOT JUDGED");
  const std::string html = read_file(folder.file("out/report.html")),
                    junit = read_file(folder.file("out/junit.xml"));
  CHECK_THAT(html, Contains("NOT JUDGED") && !Contains("verdict pass") && !Contains("badge pass"));
  CHECK_THAT(junit, Contains("skipped=\"1\"") && Contains("<skipped message="));
  const Finished compared = run(folder, {"compare", "--db", db});
  CHECK(compared.status == 0);
  CHECK_THAT(compared.out, !Contains("PASS"));
  CHECK_THAT(read_file(folder.file("out/report.html")), Contains("SIMULATED RIG"));
}

TEST_CASE("a broken limit is exit 1 in run, compare and report; the rule of decision is told", "[system]") {
  Folder folder;
  const std::string db = folder.file("a.db");
  const std::string plan = folder.write(
      "p.toml", "angles_deg = [60]\nrepeats = 1\ndecision_rule = \"guarded\"\n[limits.t_ct1]\nmax_ms = 5\n");
  CHECK(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 1);
  CHECK(report(folder, db, 1).at("verdict") == "FAIL");
  CHECK(run(folder, {"compare", "--db", db}).status == 1);
  CHECK_THAT(read_file(folder.file("out/report.html")), Contains("Guarded acceptance"));
  CHECK_THAT(read_file(folder.file("out/junit.xml")), Contains("<failure type=\"FAIL\""));
}

TEST_CASE("the largest difference from the simulation is a limit like others", "[system]") {
  Folder folder;
  for (const auto& [percent, status] : {std::pair{"1000", 0}, {"0", 1}}) {
    const std::string db = folder.file(std::string(percent) + ".db");
    const std::string plan = folder.write(
        "p.toml",
        std::string("angles_deg = [60]\nrepeats = 1\nlimits_vs_simulation_percent = ") + percent + "\n");
    REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
    REQUIRE(run(folder, {"sim", plan, "--db", db}).status == 0);
    CHECK(report(folder, db, status).at("verdict") == (status == 0 ? "PASS" : "FAIL"));
    CHECK(run(folder, {"compare", "--db", db}).status == status);
  }
}

TEST_CASE("what an import does not show stays unknown, with the reason, from store to report", "[system]") {
  Folder folder;
  const std::string db = folder.file("a.db");
  std::string text = "time [ms],contact_a [V]\n";
  for (int i = -200; i < 600; ++i) text += std::to_string(0.1 * i) + "," + (i < 130 ? "5" : "0") + "\n";
  const Finished imported = run(folder, {"import", folder.write("scope.csv", text), "--db", db});
  CHECK(imported.status == 0);
  CHECK_THAT(imported.err,
             Contains("closing angle not found: the file has no mains_voltage and coil_voltage"));
  const json campaigns = json::parse(run(folder, {"campaigns", "--db", db, "--json"}).out);
  CHECK(campaigns[0].at("origin") == "IMPORT");
  const json shot = campaigns[0].at("shots")[0];
  CHECK(shot.at("angle_deg").is_null());
  CHECK(shot.at("outcome") == "NOT JUDGED");
  CHECK_THAT(shot.at("reason").get<std::string>(), Contains("closing angle not found"));
  CHECK_THAT(run(folder, {"show", "1", "--db", db}).out, Contains("ambient not known") && !Contains("nan"));
  for (const json& row : json::parse(run(folder, {"compare", "--db", db, "--json"}).out))
    CHECK(row.at("closing_angle_deg").is_null());
  CHECK(report(folder, db, 0).at("origin") == "IMPORT");
  const std::string html = read_file(folder.file("out/report.html"));
  CHECK_THAT(html, !Contains("Behaviour over the closing angle"));  // there would be axes alone
  CHECK_THAT(html, Contains("IMPORT") && Contains("not known") && !Contains("230 V") &&
                       !Contains("Closing angle 0"));
  CHECK_THAT(read_file(folder.file("out/junit.xml")), Contains("name=\"origin\" value=\"IMPORT\""));
}

TEST_CASE("an import claims no date, no plan and no command; without a limit nothing is NOT OBSERVED",
          "[system]") {
  Folder folder;
  std::string text = "time [ms],contact_a [V]\n";
  for (int i = -200; i < 600; ++i) text += std::to_string(0.1 * i) + "," + (i < 130 ? "5" : "0") + "\n";
  folder.write("scope.csv", text);
  for (const std::string& calibration :
       {std::string(), std::string("closing_angle_deg = 90\nrecorded = \"2020-05-04\"\n")}) {
    const bool given = !calibration.empty();
    const std::string db = folder.file(given ? "given.db" : "bare.db");
    folder.write("scope.toml", calibration);
    REQUIRE(run(folder, {"import", folder.file("scope.csv"), "--db", db}).status == 0);
    REQUIRE(run(folder, {"annotate", "instrument", "clamp; Z-1; 2021-01-01", "--db", db}).status == 0);
    CHECK(report(folder, db, 0).at("verdict") == "NOT JUDGED");
    CHECK(run(folder, {"compare", "--db", db}).status == 0);
    const std::string html = read_file(folder.file("out/report.html"));
    CHECK_THAT(html, !Contains("NOT OBSERVED</span>") && !Contains("the test began on") &&
                         !Contains("Calibration expired") && !Contains("planned closings"));
    CHECK_THAT(html,
               Contains(given ? "recorded: 2020-05-04; imported on " : "recorded: not known; imported on "));
    CHECK_THAT(html, Contains("imported; nothing was planned") && Contains("50, assumed: not given"));
    CHECK((html.find("cannot be judged: when the records") != std::string::npos) == !given);
    CHECK_THAT(read_file(folder.file("out/junit.xml")),
               Contains("failures=\"0\"") && Contains("errors=\"0\""));
    if (!given) CHECK_THAT(html, Contains("the closing angle of none of these closings is known"));
    const std::string shown = run(folder, {"show", "1", "--db", db}).out;
    CHECK_THAT(shown, !Contains("asked") && Contains("hold not known"));
    CHECK_THAT(shown, Contains(given ? "given        90.00 deg" : "given        closing angle not known"));
    REQUIRE(run(folder, {"annotate", "recorded", "2022-01-01", "--db", db}).status == 0);
    report(folder, db, 0);
    CHECK_THAT(read_file(folder.file("out/report.html")),
               Contains("was valid until 2021-01-01; recorded on 2022-01-01"));
    CHECK(run(folder, {"annotate", "recorded", "yesterday", "--db", db}).status == 2);
  }
  // a day that is stated later does not hide a calibration that had expired
  folder.write("scope.toml", "recorded = \"2022-01-01\"\n");
  const std::string twice = folder.file("twice.db");
  REQUIRE(run(folder, {"import", folder.file("scope.csv"), "--db", twice}).status == 0);
  REQUIRE(run(folder, {"annotate", "instrument", "clamp; Z-1; 2021-01-01", "--db", twice}).status == 0);
  REQUIRE(run(folder, {"annotate", "recorded", "2020-05-04", "--db", twice}).status == 0);
  report(folder, twice, 0);
  CHECK_THAT(read_file(folder.file("out/report.html")),
             Contains("was valid until 2021-01-01; recorded on 2022-01-01") &&
                 Contains("stated as 2022-01-01 and then as 2020-05-04"));
  // no record is of a day to come
  folder.write("scope.toml", "recorded = \"2999-05-04\"\n");
  const Finished ahead = run(folder, {"import", folder.file("scope.csv"), "--db", folder.file("ahead.db")});
  CHECK(ahead.status == 2);
  CHECK_THAT(ahead.err, Contains("recorded = \"2999-05-04\": is a day to come"));
}

TEST_CASE("a plan by hand is not fired, and an expired instrument is said before the first shot",
          "[system]") {
  Folder folder;
  const std::string hand = folder.write("h.toml", "angles_deg = [60]\nrepeats = 1\norder = \"by_hand\"\n");
  const Finished refused = run(folder, {"run", hand, "--rig", "sim:", "--db", folder.file("h.db")});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("nobody planned; allowed random, sequential"));
  CHECK_FALSE(std::filesystem::exists(folder.file("h.db")));
  const std::string late = folder.write(
      "l.toml",
      "angles_deg = [60]\nrepeats = 1\n[test]\ninstruments = [\"clamp; Z-1; 2021-01-01\", \"laser; L-9\"]\n");
  CHECK_THAT(run(folder, {"run", late, "--rig", "sim:", "--db", folder.file("l.db")}).err,
             Contains("calibration expired: clamp, certificate Z-1, was valid until 2021-01-01"));
  report(folder, folder.file("l.db"), 0);
  CHECK_THAT(read_file(folder.file("out/report.html")),
             Contains("laser, certificate L-9, validity not stated"));
  // what a rig fired has its own days
  for (const std::string key : {"recorded", "source"}) {
    const Finished told = run(folder, {"annotate", key, "2022-01-01", "--db", folder.file("l.db")});
    CHECK(told.status == 2);
    CHECK_THAT(told.err, Contains(key + ": is told of imported records"));
  }
  const std::string ahead =
      folder.write("f.toml", "angles_deg = [60]\nrepeats = 1\n[test]\nrecorded = \"2999-05-04\"\n");
  const Finished never = run(folder, {"run", ahead, "--rig", "sim:", "--db", folder.file("f.db")});
  CHECK(never.status == 2);
  CHECK_THAT(never.err, Contains("recorded: '2999-05-04' is a day to come"));
}

TEST_CASE("the shots of a report stand in the order of their firing, with their earlier attempts",
          "[system]") {
  namespace host = powbench::host;
  Folder folder;
  const std::string db = folder.file("a.db");
  {
    host::Store store(db);
    const host::Scene scene =
        host::load_scene(folder.write("p.toml", "angles_deg = [60]\nrepeats = 3\norder = \"sequential\"\n"));
    const auto campaign = store.create_campaign(host::campaign_info(scene, "sim:", "a rig"));
    const auto fire = [&](std::size_t number, const char* time, powbench::Outcome outcome) {
      host::StoredShot s = host::stored(campaign, host::ShotKind::measured, scene.shots[number]);
      s.outcome = outcome;
      s.started = std::string("2030-12-31T") + time;
      store.store_shot(s, nullptr, nullptr, {});
    };
    fire(0, "10:00:00Z", powbench::Outcome::timeout);
    fire(1, "10:01:00Z", powbench::Outcome::error);
    fire(2, "10:02:00Z", powbench::Outcome::error);
    fire(0, "10:03:00Z", powbench::Outcome::aborted);  // the fourth in the store
  }
  CHECK(run(folder, {"report", "--db", db, "-o", folder.file("out")}).status != 2);
  CHECK_THAT(run(folder, {"shots", "--db", db}).out,
             Contains("earlier: shot 1, 60.00 deg, attempt 1, 2030-12-31T10:00:00Z: TIMEOUT"));
  const std::string html = read_file(folder.file("out/report.html"));
  const auto second = html.find("<tr><td>2</td>"), last = html.find("<tr><td>4</td>");
  REQUIRE(last != std::string::npos);
  CHECK(second < last);
  CHECK_THAT(html, Contains("1 shot was fired again after an error: 4 (TIMEOUT)."));
}

TEST_CASE("nothing is fired on a rig that was not named, and a store that is not there is called that",
          "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [60]\nrepeats = 1\n");
  const Finished unnamed = run(folder, {"run", plan, "--db", folder.file("a.db")});
  CHECK(unnamed.status == 2);
  CHECK_THAT(unnamed.err, Contains("--rig"));
  CHECK_FALSE(std::filesystem::exists(folder.file("a.db")));
  for (const char* verb : {"report", "compare", "campaigns"}) {
    const Finished r = run(folder, {verb, "--db", folder.file("none.db")});
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Contains("no such store") && !Contains("damaged"));
  }
}
