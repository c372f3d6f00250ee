#include <catch2/catch.hpp>

#include "tests/system/program.h"

using namespace powbench::test;
using Catch::Contains;

TEST_CASE("all mistakes of a plan at once, with file, line, key, range and the nearest key", "[system]") {
  Folder folder;
  const std::string plan = folder.write("bad.plan.toml",
                                        "name = \"x\"\n"
                                        "angles_deg = [0, 400]\n"
                                        "repeets = 3\n"
                                        "supply_V = \"high\"\n");
  for (const char* verb : {"run", "sim"}) {
    const Finished r = run(folder, {verb, plan, "--db", folder.file("a.db")});
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Contains("bad.plan.toml:2"));
    CHECK_THAT(r.err, Contains("400"));
    CHECK_THAT(r.err, Contains("bad.plan.toml:3"));
    CHECK_THAT(r.err, Contains("did you mean 'repeats'"));
    CHECK_THAT(r.err, Contains("bad.plan.toml:4"));
    CHECK(r.out.empty());
    CHECK_FALSE(std::filesystem::exists(folder.file("a.db")));
  }
  CHECK(run(folder, {"plan", "check", plan}).status == 2);
  CHECK(run(folder, {"plan", "check", folder.file("none.toml")}).status == 2);
}

TEST_CASE("numbers of the command line that are none, or say a thing twice, are refused by name",
          "[system]") {
  Folder folder;
  const std::string law = folder.write("a.specimen.toml", "[bridges]\ncontact_exponent = 1.5\n");
  const std::vector<std::pair<std::vector<std::string>, const char*>> wrong{
      {{"fit", "--deviations", "1,1,nan"}, "--deviations nan: not a number"},
      {{"fit", "--prior", "nan"}, "--prior nan: not a number"},
      {{"fit", "--free", "core.mass_g=100:160", "--free", "core.mass_g=90:160"}, "free already"},
      {{"fit", "--specimen", law}, "contact_exponent: allowed 1"},
      {{"fit", "--specimen", law, "--mechanics", "plant"}, "contact_exponent: allowed 1"},
      {{"fit", "--fields", "table"}, "--fields table: allowed with --db"},
      {{"fit", "--mechanics", "deformable"}, "allowed plant, rigid, modal"},
      {{"fit", "--mechanics", "elastic"}, "allowed"},
      {{"fit", "--mechanics", "rigid", "--fit", folder.file("f.json")}, "allowed without --fields"},
      {{"sweep", "--vary", "supply_volts=220:240:2.5"}, "2.5 steps: allowed a whole number"},
      {{"sweep", "--ambient", "900"}, "-50"},
      {{"ladder", "--table", folder.file("none")}, "no such file"},
      {{"specimen", "describe", "--volts", "nan"}, "--volts nan: not a number"}};
  for (const auto& [words, says] : wrong) {
    const Finished r = run(folder, words);
    INFO(words[0] << " " << words[1] << "\n" << r.err);
    CHECK(r.status == 2);
    CHECK(r.out.empty());
    CHECK_THAT(r.err, Contains(says));
  }
}

TEST_CASE("words the command line does not know", "[system]") {
  Folder folder;
  CHECK(run(folder, {}).status == 2);
  CHECK(run(folder, {"fly"}).status == 2);
  CHECK(run(folder, {"run"}).status == 2);
  CHECK(run(folder, {"run", "x", "--progress", "loud"}).status == 2);
  const Finished help = run(folder, {"--help"});
  CHECK(help.status == 0);
  CHECK_THAT(help.out, Contains("powbench demo"));
  CHECK_THAT(help.out, Contains("Exit codes"));
}

TEST_CASE(
    "an unreachable rig is exit 3, one sentence, and leaves no store behind a campaign that never began",
    "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [0]\nrepeats = 1\n");
  for (const std::string rig : {"ip:127.0.0.254", "ip:nowhere.invalid", "teapot:"}) {
    const Finished r = run(folder, {"run", plan, "--rig", rig, "--db", folder.file("a.db")});
    INFO(rig << "\n" << r.err);
    CHECK(r.status == (rig == "teapot:" ? 2 : 3));  // no such address, or nobody there
    CHECK_THAT(r.err, Contains("powbench: "));
    // libiio itself may add a line about its name service
    const std::string sentence = r.err.substr(r.err.find("powbench: "));
    CHECK(std::count(sentence.begin(), sentence.end(), '\n') == 1);
  }
  CHECK(run(folder, {"compare", "--db", folder.file("a.db")}).status == 2);
}

TEST_CASE(
    "databases that must be refused are refused untouched, with exit 5 where damaged and 2 where another "
    "file is meant",
    "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [0]\nrepeats = 1\n");
  const std::string db = folder.file("a.db");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
  const std::string good = read_file(db);

  const auto refuse = [&](const std::string& content, const std::string& word, int status = 5) {
    folder.write("a.db", content);
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"run", plan, "--rig", "sim:", "--db", db},
          {"report", "--db", db, "-o", folder.file("out")},
          {"campaigns", "--db", db}}) {
      const Finished r = run(folder, command);
      INFO(word << ": " << r.err);
      CHECK(r.status == status);
      CHECK_THAT(r.err, Contains(word));
    }
    CHECK(read_file(db) == content);
    CHECK_FALSE(std::filesystem::exists(db + "-wal"));
    CHECK_FALSE(std::filesystem::exists(db + "-journal"));
  };
  std::string newer = good;
  newer[63] = 99;
  refuse(newer, "newer powbench");
  std::string foreign = good;
  foreign[68] = 0;
  refuse(foreign, "another program", 2);
  refuse(good.substr(0, good.size() / 2), "damaged");
  refuse(good.substr(0, 50), "damaged");
  refuse("time [s],force [N]\n0,1\n" + std::string(200, ' '), "not a powbench store", 2);

  folder.write("a.db", good);
  CHECK(run(folder, {"campaigns", "--db", db}).status == 0);
  CHECK(run(folder, {"run", plan, "--rig", "sim:", "--db", folder.file("no/such/folder/a.db")}).status == 2);
  CHECK(run(folder, {"events", "77", "--db", db}).status == 2);
}
