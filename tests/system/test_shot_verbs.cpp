#include <sys/stat.h>

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/quantities.h"
#include "host/store/store.h"
#include "tests/system/program.h"

/// What a lab does with a campaign behind the run: look at single shots, complete the test record, compare before and
/// after.

using namespace powbench::test;
using namespace powbench;
using namespace powbench::host;
using Catch::Contains;
using nlohmann::json;

namespace {

const char* const record_plan =
    "name = \"before\"\nangles_deg = [30, 90]\nrepeats = 2\n[test]\ncustomer = \"A <b> & Sons\"\n"
    "instruments = [\"charge amplifier CA-7; K-2041; 2024-03-01\", \"laser; L-9\"]\n";

/// Two campaigns of four shots, the first with its simulation: shots 1 .. 4, 5 .. 8 and 9, 10.
std::string two_campaigns(const Folder& folder) {
  const std::string db = folder.file("lab.db");
  const std::string plan = folder.write("a.plan.toml", record_plan);
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--seed", "9"}).status == 0);
  return db;
}

}  // namespace

TEST_CASE("shots, show and plot: one number, the store's, for the same shot", "[system]") {
  Folder folder;
  const std::string db = two_campaigns(folder);
  REQUIRE(run(folder, {"sim", folder.file("a.plan.toml"), "--db", db}).status == 0);
  const json shots = json::parse(run(folder, {"shots", "--db", db, "--campaign", "1", "--json"}).out);
  REQUIRE(shots.size() == 6);
  const json& first = shots.at(0);
  CHECK(first.at("kind") == "measured");
  CHECK(shots.at(5).at("kind") == "simulated");
  const std::string id = std::to_string(first.at("shot").get<int>());
  const json shown = json::parse(run(folder, {"show", id, "--db", db, "--json"}).out);
  CHECK(shown.at("angle_deg") == first.at("angle_deg"));
  CHECK(shown.at("origin") == "SIMULATED RIG");
  CHECK(shown.at("sealed").get<std::string>().find("stage=complete") != std::string::npos);
  const Finished text = run(folder, {"show", id, "--db", db});
  CHECK_THAT(text.out,
             Contains("SIMULATED RIG, measured shot " + id) && Contains("t_ct1") && Contains("by the rig"));
  const Finished table = run(folder, {"shots", "--db", db, "--campaign", "1"});
  CHECK_THAT(table.out, Contains("\n     " + id + " measured") && Contains("simulated") && Contains(" +- "));

  const std::string svg = folder.file("a.svg"), html = folder.file("a.html");
  CHECK(run(folder, {"plot", id, "--db", db, "-o", svg}).status == 0);
  CHECK_THAT(read_file(svg), Contains("<svg font-family") && Contains("SIMULATED RIG") &&
                                 Contains("simulated") && Contains("force A"));
  CHECK(run(folder, {"plot", id, "--db", db, "-o", html}).status == 0);
  CHECK_THAT(read_file(html),
             Contains("SIMULATED RIG") && Contains("Shot " + id) && !Contains("http://www.w3.org/1999"));
  const Finished other = run(folder, {"plot", id, "--db", db, "-o", folder.file("a.png")});
  CHECK(other.status == 2);
  CHECK_THAT(other.err, Contains("a picture is .svg or .html"));
  CHECK(run(folder, {"show", "99", "--db", db}).status == 2);
}

TEST_CASE("test record: in the plan, completed by annotations, expired calibrations on the first page",
          "[system]") {
  Folder folder;
  const std::string db = two_campaigns(folder);
  const auto hashes = [&] {
    std::string all;
    for (const json& c : json::parse(run(folder, {"campaigns", "--db", db, "--json"}).out))
      all += c.at("plan_hash").get<std::string>() + c.at("shots").dump();
    return all;
  };
  const std::string before = hashes();
  CHECK(run(folder, {"annotate", "serial", "S 0042", "--db", db, "--campaign", "1"}).status == 0);
  CHECK(run(folder, {"annotate", "customer", "C & D", "--db", db, "--campaign", "1"}).status == 0);
  CHECK(run(folder, {"annotate", "instrument", "clamp; Z-1; 2199-01-01", "--db", db, "--campaign", "1"})
            .status == 0);
  CHECK(hashes() == before);  // what was fired and recorded is sealed
  const json notes = json::parse(run(folder, {"annotate", "--db", db, "--campaign", "1", "--json"}).out);
  REQUIRE(notes.size() == 3);
  CHECK(notes.at(0).at("text") == "S 0042");
  CHECK(json::parse(run(folder, {"annotate", "--db", db, "--json"}).out).empty());  // the other campaign

  CHECK(run(folder, {"report", "--db", db, "--campaign", "1", "-o", folder.file("out")}).status == 0);
  const std::string html = read_file(folder.file("out/report.html"));
  CHECK_THAT(
      html,
      Contains("Calibration expired: charge amplifier CA-7, certificate K-2041, was valid until 2024-03-01"));
  CHECK_THAT(html, Contains("S 0042") && Contains("C &amp; D") && !Contains("A &lt;b&gt;") &&
                       Contains("clamp, certificate Z-1"));
  CHECK_THAT(html, Contains("Completed by 3 annotations") && !Contains("expired: clamp") &&
                       !Contains("expired: laser"));
  CHECK(run(folder, {"report", "--db", db, "--campaign", "2", "-o", folder.file("out")}).status == 0);
  CHECK_THAT(read_file(folder.file("out/report.html")),
             Contains("A &lt;b&gt; &amp; Sons") && !Contains("Completed by"));

  for (const auto& [key, text, wrong] : {std::tuple{"seriell", "x", "did you mean 'serial'?"},
                                         {"serial", "  ", "the text is empty"},
                                         {"instrument", "x", "\"NAME; CERTIFICATE; LAST DAY\""},
                                         {"instrument", "x; y; 2027-02-30", "'2027-02-30' is no day"}}) {
    const Finished refused = run(folder, {"annotate", key, text, "--db", db});
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err, Contains(wrong));
  }
  CHECK(run(folder, {"annotate", "serial", "x", "--db", folder.file("none.db")}).status == 2);
  CHECK_FALSE(std::filesystem::exists(folder.file("none.db")));
  const Finished bad = run(folder, {"plan", "check",
                                    folder.write("b.plan.toml",
                                                 "angles_deg = [0]\nrepeats = 1\n[test]\n"
                                                 "instruments = [\"a; b\", \"c\"]\n")});
  CHECK(bad.status == 2);
  CHECK_THAT(bad.err, Contains("b.plan.toml:4: [test] instruments") && Contains("item 2 is no instrument"));
}

TEST_CASE("two campaigns: difference over its own U, at the angles of either", "[system]") {
  Folder folder;
  const std::string db = two_campaigns(folder);
  const Finished r = run(folder, {"compare", "1", "2", "--db", db, "--json"});
  CHECK(r.status == 0);
  const json rows = json::parse(r.out);
  REQUIRE(rows.size() > 10);
  for (const json& row : rows) {
    CHECK(row.at("n") == json({2, 2}));
    if (row.at("quantity") == "t_ct1") {
      CHECK(row.at("agreement") == "agrees");
      CHECK(row.at("U").get<double>() > 0);
    }
  }
  CHECK_THAT(run(folder, {"compare", "1", "2", "--db", db}).out,
             Contains("campaign 2, before") && Contains("diff./U") && !Contains("not alike") &&
                 !Contains("bit for bit"));
  const std::string low =
      folder.write("low.plan.toml", "angles_deg = [0]\nrepeats = 1\nsupply_volts = 200\nhold_time_ms = 90\n");
  REQUIRE(run(folder, {"run", low, "--rig", "sim:", "--db", db, "--progress", "none"}).status == 0);
  CHECK_THAT(run(folder, {"compare", "1", "3", "--db", db}).out,
             Contains("the two campaigns were not alike in\n  supply voltage: 230 V, then 200 V\n"
                      "  hold time: 100 ms, then 90 ms\n"));
  REQUIRE(run(folder, {"run", folder.file("a.plan.toml"), "--rig", "sim:", "--db", db}).status == 0);
  CHECK_THAT(run(folder, {"compare", "1", "4", "--db", db}).out,
             Contains("4 shots of the second campaign hold the records of the first, bit for bit"));
  CHECK(run(folder, {"compare", "1", "--db", db}).status == 2);
  CHECK(run(folder, {"compare", "1", "7", "--db", db}).status == 2);
  CHECK(run(folder, {"compare", "1", "2", "--campaign", "1", "--db", db}).status == 2);
}

TEST_CASE("compare A B: two imports of one file are the same record, not one seed", "[system]") {
  Folder folder;
  const std::string db = folder.file("lab.db"), csv = folder.file("shot.csv");
  const std::string plan = folder.write("a.plan.toml", "angles_deg = [90]\nrepeats = 1\n");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", folder.file("rig.db")}).status == 0);
  REQUIRE(run(folder, {"export", "1", "--db", folder.file("rig.db"), "-o", csv}).status == 0);
  const std::string calibration = read_file(folder.file("shot.toml"));
  REQUIRE(run(folder, {"import", csv, "--db", db}).status == 0);
  folder.write("shot.toml", "recorded = \"2020-05-04\"\n" + calibration);
  const Finished again = run(folder, {"import", csv, "--db", db});
  INFO(again.err);
  REQUIRE(again.status == 0);
  const Finished r = run(folder, {"compare", "1", "2", "--db", db});
  INFO(r.out << r.err);
  CHECK_THAT(r.out,
             Contains("1 shot of the second campaign holds a record of the first, bit for bit: the same "
                      "record, so their agreement says nothing") &&
                 !Contains("seed"));
}

TEST_CASE("compare A B: an angle that gave no measurement is not known, never an end of the program",
          "[system]") {
  Folder folder;
  const std::string db = folder.file("lab.db");
  const std::string plan = folder.write("a.plan.toml", "angles_deg = [30, 90]\nrepeats = 2\n");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
  {
    Store store(db);
    CampaignInfo other = store.campaign();
    const std::vector<StoredShot> shots = store.shots(other.id);
    other.name = "after", other.plan_hash = "another";
    const std::int64_t id = store.create_campaign(other);
    for (StoredShot s : shots) {
      const std::optional<Events> events = store.load_events(s.id);
      const Record record = store.load_record(s.id);
      s.campaign = id;
      const bool lost = s.angle_deg > 60;
      if (lost) s.outcome = Outcome::error, s.reason = "the rig did not answer";
      store.store_shot(s, lost ? nullptr : &record, lost ? nullptr : &*events, {"", "test"});
    }
  }
  for (const auto& [a, b] : {std::pair{"1", "2"}, {"2", "1"}}) {
    const Finished r = run(folder, {"compare", a, b, "--db", db});
    INFO(r.out << r.err);
    CHECK(r.status == 1);  // campaign 2 did not pass: shots failed
    const std::size_t n = quantity_table.size();
    CHECK_THAT(r.out, Contains(fmt::format("0 of {} differ, {} not known", n, n)) && Contains("ERROR") &&
                          !Contains("-0.00"));
    CHECK_THAT(r.out, Contains(" +- ") && Contains("+- is U"));
    const json rows = json::parse(run(folder, {"compare", a, b, "--db", db, "--json"}).out);
    CHECK(rows.size() == 2 * n);
  }
}

TEST_CASE("report --pdf: by a browser that is there, and a sentence where none is", "[system]") {
  Folder folder;
  const std::string db = two_campaigns(folder), out = folder.file("out");
  // stands in for a browser: writes the name of the page where it is told to print
  const std::string browser = folder.write("browser",
                                           "#!/bin/sh\nfor w in \"$@\"; do case $w in --print-to-pdf=*) "
                                           "pdf=${w#*=};; file://*) page=$w;; esac; done\n"
                                           "echo \"$page\" > \"$pdf\"\n");
  chmod(browser.c_str(), 0700);
  setenv("POWBENCH_BROWSER", browser.c_str(), 1);
  CHECK(run(folder, {"report", "--db", db, "-o", out, "--pdf"}).status == 0);
  CHECK_THAT(read_file(out + "/report.pdf"), Contains("file:///") && Contains("out/report.html"));
  setenv("POWBENCH_BROWSER", "/bin/false", 1);
  const Finished failed = run(folder, {"report", "--db", db, "-o", out, "--pdf"});
  CHECK(failed.status == 5);
  CHECK_THAT(failed.err, Contains("did not print it"));
  unsetenv("POWBENCH_BROWSER");
  const std::string path = getenv("PATH");
  setenv("PATH", folder.file("nothing").c_str(), 1);
  const Finished none = run(folder, {"report", "--db", db, "-o", out, "--pdf"});
  setenv("PATH", path.c_str(), 1);
  CHECK(none.status == 2);
  CHECK_THAT(none.err, Contains("no browser is installed"));
}

TEST_CASE("sim behind a measurement: under the measured conditions, with what they are uncertain by",
          "[system]") {
  Folder folder;
  const std::string db = folder.file("lab.db");
  const std::string rig = folder.write("weak.rig.toml", "[device]\nsupply_percent = -3\n");
  const std::string plan = folder.write("p.plan.toml", "angles_deg = [90]\nrepeats = 2\n");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:" + rig, "--db", db}).status == 0);
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:" + rig, "--db", db, "--seed", "2"}).status == 0);
  const auto volts = [&](const std::string& campaign) {
    for (const json& s :
         json::parse(run(folder, {"shots", "--db", db, "--campaign", campaign, "--json"}).out))
      if (s.at("kind") == "simulated")
        return json::parse(
                   run(folder, {"show", std::to_string(s.at("shot").get<int>()), "--db", db, "--json"}).out)
            .at("supply_volts")
            .get<double>();
    return 0.0;
  };
  REQUIRE(run(folder, {"sim", plan, "--db", db}).status ==
          0);  // beside the first campaign: the second has another seed
  CHECK(volts("1") == Approx(230 * 0.97).epsilon(2e-3));
  bool told = false;
  for (const json& row : json::parse(run(folder, {"compare", "--campaign", "1", "--db", db, "--json"}).out))
    if (row.at("quantity") == "t_ct1") {
      told = row.at("u_simulated").is_number() && row.at("u_simulated").get<double>() > 10e-6;
      CHECK(row.at("agreement") == "agrees");
    }
  CHECK(told);
  // the same U in the list of shots as in the report: by the inputs, far above that of the extraction
  const std::string listed = run(folder, {"shots", "--campaign", "1", "--db", db}).out;
  const std::string simulated = listed.substr(listed.find("simulated"));
  const std::size_t at = simulated.find(" +- ", simulated.find(" +- ") + 1);  // behind the angle: touch
  REQUIRE(at != std::string::npos);
  CHECK(std::stod(simulated.substr(at + 4)) > 0.02);  // ms
  const std::string shown = run(folder, {"show", "1", "--db", db}).out;
  CHECK_THAT(shown, Contains("+- is U (k = 2)") && Contains("U ") && !Contains("u 0."));
  // and where it is shown or exported alone
  const json lines = json::parse(run(folder, {"shots", "--campaign", "1", "--db", db, "--json"}).out);
  REQUIRE(lines.back().at("kind") == "simulated");
  const std::string id = lines.back().at("shot").dump();
  const std::string alone = run(folder, {"show", id, "--db", db}).out;
  CHECK_THAT(alone, Contains("+- is U (k = 2) of what its inputs leave open"));
  const std::size_t touch = alone.find("+- ", alone.find("  t_ct1 "));
  CHECK(std::stod(alone.substr(touch + 3)) > 20);  // us
  const json object = json::parse(run(folder, {"show", id, "--db", db, "--json"}).out);
  CHECK(object.at("quantities").at("t_ct1").at("u").get<double>() > 10e-6);
  const std::string table = folder.file("e.arrow");
  REQUIRE(run(folder, {"export", "--campaign", "1", "--to", "arrow", "--db", db, "-o", table}).status == 0);
  std::vector<double> exported;
  {
    const Store store(db, Store::Mode::read_only);
    exported = {store.prediction(std::stoll(id)).u.at("t_ct1"),
                store.prediction(std::stoll(id)).u.at("t_ct2")};
  }
  const std::string bytes = read_file(table);
  for (const double u : exported)
    CHECK(bytes.find(std::string(reinterpret_cast<const char*>(&u), sizeof u)) != std::string::npos);
  REQUIRE(run(folder, {"sim", plan, "--db", folder.file("other.db"), "--nominal"}).status == 0);
}
