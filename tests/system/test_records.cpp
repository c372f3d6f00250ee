#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "host/store/store.h"
#include "tests/system/program.h"

/// Records in and out and stores as a whole, by the command line.

using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

namespace {

std::string content(const Folder& folder, const std::string& db) {
  const Finished r = run(folder, {"db", "check", "--db", db, "--json"});
  CHECK(r.status == 0);
  return json::parse(r.out)["hash"];
}

}  // namespace

// POSIX: a process that closes any descriptor of a file loses all locks it holds on it. Then a reader from elsewhere,
// believing itself alone, took the log away at its end, and a running plan of the live bench ended with "disk I/O
// error".
TEST_CASE("a store that is written and read in one program may be read by another meanwhile", "[system]") {
  namespace host = powbench::host;
  const Folder folder;
  const std::string db = folder.file("a.db");
  host::Store writer(db);
  for (int i = 1; i <= 3; ++i) {
    host::CampaignInfo campaign;
    campaign.name = "number " + std::to_string(i);
    REQUIRE(writer.create_campaign(campaign) == i);
    CHECK(host::Store(db, host::Store::Mode::read_only).campaigns().size() == static_cast<std::size_t>(i));
    const Finished other = run(folder, {"campaigns", "--db", db, "--json"});
    CHECK(other.status == 0);
    CHECK(json::parse(other.out).size() == static_cast<std::size_t>(i));
  }
}

TEST_CASE("a store is checked, taken apart, put together, exported", "[system]") {
  const Folder folder;
  const std::string db = folder.file("a.db"),
                    plan = folder.write("p.toml", "angles_deg = [0, 90]\nrepeats = 1\n");
  for (const char* seed : {"1", "2"})
    REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db, "--seed", seed, "--progress", "none"})
                .status == 0);
  const std::string whole = content(folder, db);
  const Finished split = run(folder, {"db", "split", "--db", db, "-o", folder.file("parts")});
  REQUIRE(split.status == 0);
  const std::string one = folder.file("parts/campaign-1.db"), two = folder.file("parts/campaign-2.db");
  REQUIRE(run(folder, {"db", "merge", two, one, two, "-o", folder.file("b.db")}).status == 0);
  CHECK(content(folder, folder.file("b.db")) == whole);
  const Finished self = run(folder, {"db", "merge", db, "-o", db});
  CHECK(self.status == 2);
  CHECK_THAT(self.err, Contains("is the target itself"));
  CHECK_THAT(run(folder, {"db", "migrate", "--db", db}).out, Contains("0 records packed"));
  CHECK(run(folder, {"db", "check", "--db", folder.file("none.db")}).status == 2);

  for (const char* to : {"nc", "comtrade", "xlsx"}) {
    const Finished r =
        run(folder, {"export", "1", "--to", to, "--db", db, "-o", folder.file(std::string("x.") + to)});
    INFO(to << r.err);
    CHECK((r.status == 0 || r.err.find("built without HDF5") != std::string::npos));
  }
  REQUIRE(run(folder, {"export", "--to", "arrow", "--db", db, "-o", folder.file("e.arrow")}).status == 0);
  CHECK(run(folder, {"export", "--to", "xlsx", "--db", db, "-o", folder.file("e.xlsx")}).status == 0);
  CHECK_THAT(run(folder, {"export", "--to", "nc", "--db", db, "-o", folder.file("e.nc")}).err,
             Contains("name a shot"));
  CHECK_THAT(run(folder, {"export", "1", "--to", "nc", "--db", db}).err,
             Contains("name the file to write with -o"));

  // COMTRADE comes back with the same events
  folder.write("x.toml", "[columns]\npvdf_a = \"pvdf_a\"\npvdf_b = \"pvdf_b\"\nlaser = \"laser\"\n");
  const Finished back = run(folder, {"events", folder.file("x.cfg"), "--json"});
  INFO(back.err);
  REQUIRE(back.status == 0);
  const json before = json::parse(run(folder, {"events", "1", "--db", db, "--json"}).out),
             after = json::parse(back.out);
  CHECK(std::abs(before["core"]["seat_s"]["value"].get<double>() - after["core"]["seat_s"].get<double>()) <
        1e-6);
}

TEST_CASE("a scope's file: suggest, import; a broken one is one sentence and nothing stored", "[system]") {
  const Folder folder;
  std::string rows;
  for (int i = 0; i < 400; ++i)
    rows += std::to_string(i * 1e-4 - 0.01) + "," +
            std::to_string(i > 150 ? 2.0 + 0.01 * (i % 3) : 0.01 * (i % 3)) + "\n";
  const std::string file =
      folder.write("scope.csv", "Model,X\nSample Interval,1e-4\nTIME,Force A (V)\n" + rows);
  const Finished first = run(folder, {"import", file, "--db", folder.file("a.db")});
  CHECK(first.status == 2);
  CHECK_THAT(first.err, Contains("'Force A [V]': is not known") && Contains("powbench import --suggest"));
  const std::string calibration = folder.file("scope.toml");
  const Finished suggested = run(folder, {"import", file, "--suggest", "-o", calibration});
  REQUIRE(suggested.status == 0);
  CHECK_THAT(suggested.err, Contains("Force A [V]") && Contains("pvdf_a") && Contains("by name"));
  CHECK(run(folder, {"import", file, "--suggest", "-o", calibration}).status == 2);  // not overwritten
  const Finished ungained = run(folder, {"import", file, "--db", folder.file("a.db")});
  CHECK(ungained.status == 2);
  CHECK_THAT(ungained.err, Contains("gain_N_per_V"));
  folder.write("scope.toml", read_file(calibration) + "\n[pvdf_a]\ncertificate = \"film.xml\"\n");
  CHECK_THAT(run(folder, {"import", file, "--db", folder.file("a.db")}).err,
             Contains("scope.toml") || Contains("film.xml"));
  CHECK_FALSE(std::filesystem::exists(folder.file("a.db")));
  folder.write("scope.toml", "[columns]\npvdf_a = \"Force A\"\n[pvdf_a]\ncertificate = \"film.xml\"\n");
  folder.write("film.xml",
               "<digitalCalibrationCertificate><coreData><uniqueIdentifier>K "
               "1</uniqueIdentifier></coreData><measurementResults><quantity><real>"
               "<value>5</value><unit>\\newton\\per\\volt</unit></real></quantity></measurementResults></"
               "digitalCalibrationCertificate>");
  const Finished stored = run(folder, {"import", file, "--db", folder.file("a.db")});
  INFO(stored.err);
  CHECK(stored.status == 0);
  CHECK_THAT(stored.err, Contains("gain 5 N/V from certificate K 1"));

  for (const auto& [name, bytes, why] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {"cut.csv", "Record Length,500,,0,1\nA,B,,1e-4,1\nA,B,,2e-4,1\n", "states 500 samples"},
           {"bad.csv", "Model,X\nFirmware,2\n\n0,1,2\n1,1,2\n2,1,2\n", "the preamble is not understood"},
           {"cut.tdms", "TDSm\x0e", "it is cut or damaged"},
           {"bad.mat", "MATLAB 7.3 MAT-file, HDF5 schema 1.00", "is no MAT-file of level 5"},
           {"alone.wvf", "x", "alone.HDR is missing beside it"}}) {
    const Finished r = run(folder, {"import", folder.write(name, bytes), "--db", folder.file("none.db")});
    INFO(name << ": " << r.err);
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Contains(why));
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK_FALSE(std::filesystem::exists(folder.file("none.db")));
  }
}
