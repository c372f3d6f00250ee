#include <sqlite3.h>

#include <catch2/catch.hpp>

#include "tests/system/program.h"

/// A store whose rows were altered behind powbench's back. Every verb that meets such a row says so and ends with 5.

using namespace powbench::test;

namespace {

void alter(const std::string& path, const std::string& statement) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &db) == SQLITE_OK);
  const int status = sqlite3_exec(db, statement.c_str(), nullptr, nullptr, nullptr);
  sqlite3_close(db);
  REQUIRE(status == SQLITE_OK);
}

}  // namespace

TEST_CASE("rows with sizes that overflow or wrong seals end every verb that reads them with 5", "[system]") {
  Folder folder;
  const std::string plan = folder.write("p.toml", "angles_deg = [0, 90]\nrepeats = 2\n");
  const std::string db = folder.file("a.db");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", db}).status == 0);
  const std::string good = read_file(db);

  using Command = std::vector<std::string>;
  const Command table{"compare", "--db", db}, page{"report", "--db", db, "-o", folder.file("out")};
  const Command wave{"export", "1", "--db", db, "-o", folder.file("a.csv")};
  const std::vector<std::pair<std::string, std::vector<Command>>> cases{
      {"UPDATE record SET samples = 9223372036854775807", {wave, page}},
      {"UPDATE record SET samples = -1", {wave, page}},
      {"UPDATE record SET samples = 1152921504606846976", {wave, page}},
      {"UPDATE record SET scans = x'00'", {wave, page}},
      {"UPDATE record SET sample_rate = 9e999", {wave, page}},
      {"UPDATE record SET gaps = '[[-5, 9223372036854775807]]'", {wave, page}},
      {"UPDATE record SET seal = 'x'", {wave, page}},
      {"UPDATE record SET sealed = 'other'", {wave, page}},
      {"UPDATE channel SET scale = 2 * scale", {wave, page}},
      {"UPDATE events SET events = '{}'", {table, page}},
      {"UPDATE events SET seal = 'x'", {table, page}},
      {"UPDATE shot SET angle_deg = 45", {table, page}},
      {"UPDATE shot SET conditions = '{'", {table, page}},
      {"UPDATE shot SET seal = 'x'", {table, page}},
      {"UPDATE campaign SET plan = 'repeats = 1'", {table, page}},
      {"UPDATE campaign SET seal = 'x'",
       {table, page, {"campaigns", "--db", db}, {"run", plan, "--rig", "sim:", "--db", db, "--resume"}}},
  };
  for (const auto& [statement, commands] : cases) {
    folder.write("a.db", good);
    alter(db, statement);
    for (const Command& command : commands) {
      const Finished r = run(folder, command);
      INFO(statement << "\n" << command[0] << ": " << r.err);
      CHECK(r.status == 5);
      CHECK(r.err.find("powbench: ") != std::string::npos);
    }
  }
}
