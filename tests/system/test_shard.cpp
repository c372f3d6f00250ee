#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "tests/system/program.h"

/// One sweep in parts that do not know of each other. On a cluster: tests/cluster/test_slurm.sh.

using namespace powbench::test;
using Catch::Contains;

namespace {

std::string content_hash(const Folder& folder, const std::string& db) {
  const Finished r = run(folder, {"db", "check", "--db", db, "--json"});
  REQUIRE(r.status == 0);
  return nlohmann::json::parse(r.out).at("hash");
}

}  // namespace

TEST_CASE("shards of a sweep, merged in any order and one of them twice, are the sweep", "[system]") {
  const Folder folder;
  const auto sweep = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"sweep",  "--vary", "angle_deg=0:180", "--points", "1700",
                                   "--seed", "5",      "--progress",      "none"};
    words.insert(words.end(), more.begin(), more.end());
    return run(folder, words);
  };
  const std::string whole = folder.file("whole.db");
  const Finished serial = sweep({"--db", whole});
  REQUIRE(serial.status == 0);
  std::vector<std::string> parts;
  for (int i = 1; i <= 3; ++i) {
    parts.push_back(folder.file(std::to_string(i) + ".db"));
    const Finished r = sweep({"--db", parts.back(), "--shard", std::to_string(i) + "/3"});
    REQUIRE(r.status == 0);
    CHECK(r.out.empty());  // the result is of all
    CHECK_THAT(r.err,
               Contains("shard " + std::to_string(i) + "/3: " + (i == 1 ? "2" : "1") + " of 4 blocks"));
    CHECK(content_hash(folder, parts.back()) != content_hash(folder, whole));
  }
  const std::string a = folder.file("a.db"), b = folder.file("b.db");
  CHECK(run(folder, {"db", "merge", "-o", a, parts[0], parts[1], parts[2]}).status == 0);
  CHECK(run(folder, {"db", "merge", "-o", b, parts[2], parts[0], parts[2], parts[1]}).status == 0);
  CHECK(content_hash(folder, a) == content_hash(folder, whole));
  CHECK(content_hash(folder, b) == content_hash(folder, whole));
  CHECK(sweep({"--db", a}).out == serial.out);  // everything is there: nothing is simulated
  // what one shard lacks is simulated where the result is asked for
  CHECK(sweep({"--db", parts[1]}).out == serial.out);
  CHECK(content_hash(folder, parts[1]) == content_hash(folder, whole));
}

TEST_CASE("a shard that is none, and the script for a cluster", "[system]") {
  const Folder folder;
  for (const char* wrong : {"0/3", "4/3", "3", "1/", "/2", "a/b", "1/2/3", "1/2000000"}) {
    const Finished r =
        run(folder, {"sweep", "--vary", "angle_deg=0:180", "--db", folder.file("x.db"), "--shard", wrong});
    CHECK(r.status == 2);
    CHECK_THAT(r.err, Contains("allowed I/N, part I of N, such as 3/97"));
  }
  CHECK_FALSE(std::filesystem::exists(folder.file("x.db")));
  CHECK_THAT(run(folder, {"sweep", "--best-angle", "--shard", "1/2"}).err, Contains("are of sweeps"));
  const std::vector<std::string> six_blocks{"sweep", "--vary", "supply_volts~230:2", "--points", "3000",
                                            "--db",  "a b.db"};
  const auto with = [&](const char* shards) {
    std::vector<std::string> words = six_blocks;
    words.insert(words.end(), {"--slurm", shards});
    return run(folder, words);
  };
  CHECK_THAT(with("97").err,
             Contains("--slurm 97: allowed 1 .. 6: a shard takes whole blocks of 500 points"));
  const Finished script = with("6");
  CHECK(script.status == 0);
  CHECK_THAT(script.out,
             Contains("export POWBENCH_DB='a b.db' POWBENCH_SHARDS=6") &&
                 Contains("exec powbench sweep --vary 'supply_volts~230:2' --points 3000 --shard"));
}

TEST_CASE("a shard starts without the libraries that only other commands need", "[system]") {
  const std::unique_ptr<FILE, int (*)(FILE*)> ldd(popen(("ldd " + program()).c_str(), "r"), pclose);
  REQUIRE(ldd);
  std::string linked;
  std::array<char, 256> line;
  while (fgets(line.data(), line.size(), ldd.get()) != nullptr) linked += line.data();
  CHECK_THAT(linked, Contains("libsqlite3.so"));
  for (const char* late : {"libcholmod.so", "libpq.so", "libhdf5"}) CHECK_THAT(linked, !Contains(late));
}
