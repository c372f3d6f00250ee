#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/system/program.h"

/// `field`, `ladder` and `sim` in parts that do not know of each other: what the parts find is what one run prints.
/// Fits: tests/host/test_study_fit.cpp.

using namespace powbench::test;
using Catch::Contains;

namespace {

using Words = std::vector<std::string>;

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A verb, and what is the same in each of its runs. Files that it writes besides its text lie in `out`.
struct Study {
  const Folder& folder;
  Words words;

  /// stdout, with the files it wrote. `out` is empty before and after.
  Finished operator()(const Words& more) const {
    Finished r = run(folder, words + more);
    for (const auto& file : std::filesystem::directory_iterator(folder.file("out")))
      if (r.status == 0 && !file.path().string().ends_with(".db")) r.out += read_file(file.path().string());
    std::filesystem::remove_all(folder.file("out"));
    std::filesystem::create_directory(folder.file("out"));
    return r;
  }
};

/// In 1, 3 and 7 parts, merged in order, backwards, and one of them twice; one part left out; one damaged.
void check_parts(const Folder& folder, const Study& study, std::int64_t points) {
  const auto computed = [&](std::int64_t n, std::int64_t found) {
    return std::to_string(n) + " of " + std::to_string(n + found) + (n + found == 1 ? " point" : " points") +
           " computed, " + std::to_string(found) + " found";
  };
  const Finished serial = study({"--points-db", folder.file("serial.db")});
  INFO(serial.err);
  REQUIRE(serial.status == 0);
  REQUIRE(serial.out.size() > 100);
  CHECK_THAT(serial.err, Contains(computed(points, 0)));
  for (const int n : {1, 3, 7}) {
    Words parts;
    std::int64_t left = points;
    for (int i = 1; i <= n; ++i) {
      parts.push_back(folder.file(std::to_string(i) + "of" + std::to_string(n) + ".db"));
      const Finished r =
          study({"--points-db", parts.back(), "--shard", std::to_string(i) + "/" + std::to_string(n)});
      INFO(r.err);
      REQUIRE(r.status == 0);
      CHECK((n == 1 || r.out.empty()));  // the result is of all
      const std::int64_t own = points / n + (i <= points % n ? 1 : 0);
      CHECK_THAT(r.err, Contains(computed(own, 0)));
      left -= own;
    }
    CHECK(left == 0);
    const Words backwards(parts.rbegin(), parts.rend());
    const std::string forth = folder.file("forth.db"), back = folder.file("back.db");
    REQUIRE(run(folder, Words{"db", "merge", "-o", forth} + parts).status == 0);
    REQUIRE(run(folder, Words{"db", "merge", "-o", back} + backwards + Words{parts.front()}).status == 0);
    for (const std::string& all : n == 3 ? Words{forth, back} : Words{forth}) {
      const Finished r = study({"--points-db", all});
      CHECK(r.out == serial.out);
      CHECK_THAT(r.err, Contains(computed(0, points)));
      std::filesystem::remove(all);
    }
  }
  // a part that is run again finds what it had; the run that collects computes what is missing
  const std::string two = folder.file("2of3.db"), rest = folder.file("rest.db");
  CHECK_THAT(study({"--points-db", two, "--shard", "2/3"}).err, Contains("0 of"));
  REQUIRE(run(folder, {"db", "merge", "-o", rest, folder.file("1of3.db"), folder.file("3of3.db")}).status ==
          0);
  const Finished r = study({"--points-db", rest});
  CHECK(r.out == serial.out);
  const std::int64_t missing = points / 3 + (points % 3 > 1 ? 1 : 0);
  CHECK_THAT(r.err, Contains(computed(missing, points - missing)));
}

/// Flips one bit in the content of a stored point: behind the name of its study and the 64 digits of its seal.
void damage(const std::string& file, const std::string& study) {
  std::string bytes = read_file(file);
  const auto sealed = [&](std::size_t at) {
    const std::string seal = bytes.substr(at + study.size(), 64);
    return seal.size() == 64 && seal.find_first_not_of("0123456789abcdef") == std::string::npos;
  };
  std::size_t at = bytes.find(study);
  while (at != std::string::npos && !sealed(at)) at = bytes.find(study, at + 1);
  REQUIRE(at != std::string::npos);
  char& hit = bytes[at + study.size() + 64 + 20];
  hit = static_cast<char>(hit ^ 1);
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("a field table in parts is the table of one run; another shape finds none", "[.slow]") {
  const Folder folder;
  std::filesystem::create_directory(folder.file("out"));
  const auto of = [&](const char* text) {
    return Study{
        folder,
        {"field", folder.write("x.specimen.toml", text), "-o", folder.file("out"), "--accuracy", "1%"}};
  };
  const Study study = of("[shape]\nlegs = 2\nring_share = 0.0\nouter_width_mm = 12.0\nyoke_mm = 12.0\n");
  constexpr std::int64_t points = 6;  // of four gaps each; the last of 21 stands alone
  check_parts(folder, study, points);
  const Finished other = of("[shape]\nlegs = 2\nring_share = 0.0\nouter_width_mm = 12.0\nyoke_mm = 12.5\n")(
      {"--points-db", folder.file("serial.db")});
  CHECK_THAT(other.err, Contains("6 of 6 points computed, 0 found"));
  // a damaged part: one sentence, and the target is as it was
  damage(folder.file("1of3.db"), "field");
  const std::string all = folder.file("all.db");
  const Finished refused =
      run(folder, {"db", "merge", "-o", all, folder.file("2of3.db"), folder.file("1of3.db")});
  CHECK(refused.status == 5);
  CHECK_THAT(refused.err, Contains("1of3.db") && Contains("damaged") && Contains("nothing was merged"));
  CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);
  CHECK_FALSE(std::filesystem::exists(all));
}

TEST_CASE("cells of a ladder in parts are the ladder of one run; another specimen finds none", "[system]") {
  const Folder folder;
  std::filesystem::create_directory(folder.file("out"));
  const Study study{folder, {"ladder", "--mechanics", "plant", "--angle", "70", "-o", folder.file("out")}};
  constexpr std::int64_t points = 12;  // truth, eight tolerances, one finer; input error; bounces
  check_parts(folder, study, points);
  const Finished heavier = run(
      folder, {"ladder", folder.write("h.specimen.toml", "[core]\nmass_g = 111\n"), "--mechanics", "plant",
               "--angle", "70", "-o", folder.file("out"), "--points-db", folder.file("serial.db")});
  CHECK_THAT(heavier.err, Contains("12 of 12 points computed, 0 found"));
  const Finished turned = run(folder, {"ladder", "--mechanics", "plant", "--angle", "71", "-o",
                                       folder.file("out"), "--points-db", folder.file("serial.db")});
  CHECK_THAT(turned.err, Contains("12 of 12 points computed, 0 found"));
}

TEST_CASE("closings of a plan in parts are the campaign of one run; another specimen finds none", "[.slow]") {
  const Folder folder;
  std::filesystem::create_directory(folder.file("out"));
  const std::string plan = folder.write(
      "p.plan.toml",
      "name = \"parts\"\nspecimen = \"s.specimen.toml\"\nangles_deg = [0, 45, 90, 135]\nrepeats = 1\n");
  folder.write("s.specimen.toml", "[core]\nmass_g = 111\n");
  // each run simulates into a store of its own: its campaign is new each time
  const Study study{folder, {"sim", plan, "--db", folder.file("out/c.db"), "--json", "--progress", "none"}};
  check_parts(folder, study, 4);
  folder.write("s.specimen.toml", "[core]\nmass_g = 112\n");
  CHECK_THAT(study({"--points-db", folder.file("serial.db")}).err,
             Contains("4 of 4 points computed, 0 found"));
}

TEST_CASE("measured closings are simulated in parts under the conditions they had", "[.slow]") {
  const Folder folder;
  const std::string plan = folder.write("p.plan.toml",
                                        "name = \"parts\"\nangles_deg = [30, 120]\nrepeats = 2\n"),
                    lab = folder.file("lab.db"), other = folder.file("other.db"), all = folder.file("all.db");
  REQUIRE(run(folder, {"run", plan, "--rig", "sim:", "--db", lab, "--progress", "none"}).status == 0);
  std::filesystem::copy_file(lab, other);
  const auto simulate = [&](const std::string& db, const Words& more) {
    const Finished r = run(folder, Words{"sim", plan, "--db", db, "--json", "--progress", "none"} + more);
    INFO(r.err);
    REQUIRE(r.status == 0);
    return r;
  };
  const Finished serial = simulate(lab, {});
  for (const char* i : {"1", "2"}) {
    const std::string shard = std::string(i) + "/2";
    CHECK_THAT(simulate(other, {"--points-db", folder.file(std::string(i) + ".db"), "--shard", shard}).err,
               Contains("1 of 1 point computed"));
  }
  REQUIRE(run(folder, {"db", "merge", "-o", all, folder.file("2.db"), folder.file("1.db")}).status == 0);
  const Finished collected = simulate(other, {"--points-db", all});
  CHECK(collected.out == serial.out);
  CHECK_THAT(collected.err, Contains("0 of 2 points computed, 2 found"));
  const auto compared = [&](const std::string& db) {
    return run(folder, {"compare", "--db", db, "--json"}).out;
  };
  CHECK(compared(lab).size() > 1000);
  CHECK(compared(lab) == compared(other));
}

TEST_CASE("what cannot be shared out is refused with a sentence; the script names the store of the points",
          "[system]") {
  const Folder folder;
  const auto refused = [&](const Words& words) {
    const Finished r = run(folder, words);
    CHECK(r.status == 2);
    CHECK(r.out.empty());
    return r.err;
  };
  const Words part{"--points-db", folder.file("p.db"), "--shard", "1/2"};
  CHECK_THAT(refused({"ladder", "--shard", "1/2"}), Contains("name a store for its points with --points-db"));
  CHECK_THAT(refused({"ladder", "--slurm", "3"}), Contains("name a store for the points with --points-db"));
  CHECK_THAT(refused(Words{"ladder", "--accuracy", "1%"} + part),
             Contains("there are no points to share out"));
  CHECK_THAT(refused(Words{"field", "--ends"} + part), Contains("allowed without --ends"));
  CHECK_THAT(refused(Words{"field", "--mesh", "x.msh"} + part), Contains("one state"));
  CHECK_THAT(refused(Words{"fit", "--state", "s.json"} + part), Contains("allowed one of them"));
  CHECK_THAT(refused({"fit", "--points-db", "p.db", "--shard", "3/2"}), Contains("allowed I/N"));
  const Finished script =
      run(folder, {"field", "--ring", "--points-db", "a b.db", "--slurm", "9", "-j", "4"});
  CHECK(script.status == 0);
  CHECK_THAT(script.out,
             Contains("export POWBENCH_DB='a b.db' POWBENCH_SHARDS=9") &&
                 Contains("exec powbench field --ring --shard \"$shard/$POWBENCH_SHARDS\" --points-db ") &&
                 Contains("-j \"${SLURM_CPUS_PER_TASK:-1}\"\n"));
  CHECK_THAT(
      run(folder, {"ladder", "s.toml", "--fields", "table", "circuit", "--points-db", "p.db", "--slurm", "2"})
          .err,
      Contains("s.toml"));
}
