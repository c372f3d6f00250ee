#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/host/report_xml_check.h"
#include "tests/system/program.h"

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

TEST_CASE("the demo: every shot recorded, simulated, compared and reported", "[system]") {
  Folder folder;
  const Finished demo = run(folder, {"demo", "-o", folder.file("demo"), "--progress", "none"});
  INFO(demo.err);
  REQUIRE(demo.status == 0);
  CHECK(demo.out == folder.file("demo/report.html") + "\n");
  const std::string db = folder.file("demo/demo.db");

  // 7 angles, 3 repeats, all recorded, each angle simulated once
  const json campaigns = json::parse(run(folder, {"campaigns", "--db", db, "--json"}).out);
  REQUIRE(campaigns.size() == 1);
  CHECK(campaigns[0].at("finished") == true);
  int measured = 0, simulated = 0;
  for (const json& s : campaigns[0].at("shots")) {
    (s.at("kind") == "measured" ? measured : simulated) += 1;
    CHECK(s.at("outcome") == (s.at("kind") == "measured" ? "PASS" : "NOT JUDGED"));
    CHECK(s.at("record_sha256").get<std::string>().size() == 64);
  }
  CHECK(measured == 21);
  CHECK(simulated == 7);

  // a record costs about 16 B a sample
  const auto bytes = static_cast<double>(std::filesystem::file_size(db));
  CHECK(bytes / (28 * 14'000) < 18.0);

  // the published closing range, measured and simulated
  for (const json& r : json::parse(run(folder, {"compare", "--db", db, "--json"}).out)) {
    if (r.at("closing_angle_deg").get<double>() < 29) continue;
    for (const char* kind : {"measured", "simulated"}) {
      INFO(r.dump());
      if (r.at("quantity") == "t_ct1") {
        CHECK(r.at(kind).get<double>() > 11e-3);
        CHECK(r.at(kind).get<double>() < 18.5e-3);
      }
      if (r.at("quantity") == "t_xt1") {
        CHECK(r.at(kind).get<double>() > 13e-3);
        CHECK(r.at(kind).get<double>() < 20e-3);
      }
    }
  }

  const std::string page = read_file(folder.file("demo/report.html"));
  CHECK(page.size() < 6'000'000);
  CHECK(page.find("<section id=\"closer\"") != std::string::npos);
  const std::string html = powbench::host::test::without_own_scripts(page);
  for (const char* part :
       {"<svg", "bounce", "commanded", "SIMULATED RIG", "Best closing angle", "Definitions"}) {
    INFO(part);
    CHECK(html.find(part) != std::string::npos);
  }
  CHECK(html.find("ublished") == std::string::npos);  // another device's numbers say nothing about this one
  // self-contained, and nothing unknown is printed as a number
  for (const char* foreign : {"https://", "<script", "<link", "src=", ">nan", "nan ", "NaN", ">inf"}) {
    INFO(foreign);
    CHECK(html.find(foreign) == std::string::npos);
  }
  const std::string junit = read_file(folder.file("demo/junit.xml"));
  CHECK_THAT(junit, Contains("<testsuite"));

  // once more, with a plan that somebody has changed: nothing of his is lost
  const std::string plan = folder.file("demo/demo.plan.toml");
  const std::string edited = "name = \"mine\"\nangles_deg = [45]\nrepeats = 1\n";
  folder.write("demo/demo.plan.toml", edited);
  const Finished again = run(folder, {"demo", "-o", folder.file("demo"), "--progress", "none"});
  INFO(again.err);
  CHECK(again.status == 0);
  CHECK_THAT(again.err, Contains("demo.plan.toml is not as the demo writes it: kept and used"));
  CHECK(read_file(plan) == edited);
  const json both = json::parse(run(folder, {"campaigns", "--db", db, "--json"}).out);
  REQUIRE(both.size() == 2);
  CHECK(both[0].at("shots").size() + both[1].at("shots").size() == 30);
}

TEST_CASE("the demo has one verdict: in the report, in its sentences and as its exit code", "[system]") {
  Folder folder;
  const std::string plan = "angles_deg = [60]\nrepeats = 2\n";
  std::filesystem::create_directories(folder.file("demo"));
  const auto demo = [&](const std::string& more) {
    folder.write("demo/demo.plan.toml", plan + more);
    return run(folder, {"demo", "-o", folder.file("demo"), "--progress", "none"});
  };
  const Finished off = demo("limits_vs_simulation_percent = 0\n");
  INFO(off.err);
  CHECK(off.status == 1);
  CHECK_THAT(off.err, Contains("SIMULATED RIG: FAIL") && Contains("\nVerdict FAIL: ") &&
                          Contains("further from the simulation than the plan allows") &&
                          !Contains("within the limits"));
  const Finished both = demo("limits_vs_simulation_percent = 0\n[limits.t_ct1]\nmax_ms = 100\n");
  CHECK(both.status == 1);
  CHECK_THAT(both.err, Contains("\nVerdict FAIL: 2 of 2 closings are within the limits of the plan, but ") &&
                           Contains("further from the simulation than the plan allows"));
  const Finished bare = demo("");
  CHECK(bare.status == 0);
  CHECK_THAT(bare.err,
             Contains("\nVerdict NOT JUDGED: the plan has no limits") && !Contains("within the limits"));
  const Finished broken = demo("[limits.t_ct1]\nmax_ms = 1\n");
  CHECK(broken.status == 1);
  CHECK_THAT(broken.err, Contains("\nVerdict FAIL: 0 of 2 closings are within the limits of the plan."));
}

TEST_CASE("a campaign is the same, record for record, when it is run again", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [0, 90]\nrepeats = 2\nseed = 5\n");
  std::vector<std::string> hashes[2];
  for (int i = 0; i < 2; ++i) {
    const std::string db = folder.file("run" + std::to_string(i) + ".db");
    REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--progress", "none"}).status == 0);
    const json campaigns = json::parse(run(folder, {"campaigns", "--db", db, "--json"}).out);
    for (const json& s : campaigns[0].at("shots")) hashes[i].push_back(s.at("record_sha256"));
  }
  CHECK(hashes[0].size() == 4);
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("tables as JSON: all published rows, ours beside them", "[system]") {
  Folder folder;
  const json rows = json::parse(run(folder, {"tables", "--json"}).out);
  CHECK(rows.size() >= 54);
  std::size_t ours = 0;
  for (const json& r : rows) {
    for (const char* key :
         {"paper", "table", "theta_deg", "quantity", "unit", "published_simulation", "published_measurement",
          "published_error_percent", "ours", "error_percent", "excluded"}) {
      INFO(key);
      REQUIRE(r.contains(key));
    }
    ours += r.at("ours").is_number();
    if (r.at("excluded") == false && r.at("ours").is_number() &&
        r.at("published_measurement").get<double>() != 0.0) {
      const double measured = r.at("published_measurement").get<double>();
      const double error = 100 * std::abs(r.at("ours").get<double>() - measured) / std::abs(measured);
      CHECK(r.at("error_percent").get<double>() == Approx(error).margin(0.005));
    }
  }
  CHECK(ours >= 40);
}

TEST_CASE("export gives every sample in SI", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [45]\nrepeats = 1\n");
  const std::string db = folder.file("a.db");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
  const Finished csv = run(folder, {"export", "1", "--db", db, "--to", "csv"});
  CHECK(csv.status == 0);
  CHECK(
      csv.out.starts_with("# SIMULATED RIG, campaign 1, measured shot 1\ntime [s],pvdf_a [N],pvdf_b "
                          "[N],laser [m],coil_current [A],"));
  CHECK(std::count(csv.out.begin(), csv.out.end(), '\n') == 14'002);
}
