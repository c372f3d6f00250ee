#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/system/program.h"

/// What a report may claim: nothing is passed without a limit, nothing unknown becomes a number, and everything says where it
/// comes from.

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
  CHECK_THAT(html, Contains("IMPORT") && Contains("not known") && !Contains("230 V") &&
                       !Contains("Closing angle 0"));
  CHECK_THAT(read_file(folder.file("out/junit.xml")), Contains("name=\"origin\" value=\"IMPORT\""));
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
