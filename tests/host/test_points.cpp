#include "host/store/points.h"

#include <sqlite3.h>

#include <catch2/catch.hpp>

#include "core/random.h"
#include "host/store/maintain.h"
#include "host/store/point_bytes.h"
#include "host/store/sweep_store.h"
#include "tests/host/store_samples.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Contains;

namespace {

/// A content that says what it is of, with bytes that no text has.
std::string content_of(int k) {
  Random random(static_cast<std::uint64_t>(k));
  ByteWriter out;
  out.add(std::vector<double>{random.normal(), std::nan(""), -0.0})
      .add(std::string_view("a\0b", 3))
      .add(std::int64_t{k});
  return out.bytes();
}

std::string get(Points& points, int k) {
  const auto there = points.get(k, "specimen and point " + std::to_string(k), [&] { return content_of(k); });
  return there.value_or("");
}

void change(const std::string& path, const std::string& statement) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &db) == SQLITE_OK);
  CHECK(sqlite3_exec(db, statement.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(db);
}

std::string point_hash_of(const std::string& store) {
  return check_store(store).hash;
}

}  // namespace

TEST_CASE("points are found under what they depend on, and only there", "[store][points]") {
  const Folder folder;
  for (int k = 0; k < 5; ++k) {
    Points points(folder.file(), "ladder");
    CHECK(get(points, 2) == content_of(2));
    CHECK(points.computed() == (k == 0 ? 1 : 0));
    CHECK(points.found() == (k == 0 ? 0 : 1));
  }
  const auto found = [&](const std::string& study, const std::string& program, const std::string& basis) {
    Points points(folder.file(), study, {}, program);
    points.get(0, basis, [] { return std::string("other"); });
    return points.found();
  };
  CHECK(found("ladder", "", "specimen and point 2") == 1);
  CHECK(found("ladder", "0.0.9", "specimen and point 2") == 0);  // another version of the program
  CHECK(found("fit", "", "specimen and point 2") == 0);
  CHECK(found("ladder", "", "specimen and point 2 ") == 0);
  Points none;
  CHECK(get(none, 7) == content_of(7));
  CHECK_FALSE(none.stored());
}

TEST_CASE("shards of points, merged in any order and grouping, are one store", "[store][points]") {
  const Folder folder;
  constexpr int count = 23;
  const auto part = [&](int i, int n) {
    const std::string file = folder.file(std::to_string(i) + "of" + std::to_string(n) + ".db");
    Points points(file, "field", {i, n});
    for (int k = 0; k < count; ++k) CHECK(get(points, k).empty() != (k % n == i - 1));
    return file;
  };
  const std::string whole = part(1, 1), one = point_hash_of(whole);
  for (const int n : {2, 5, 40}) {
    std::vector<std::string> parts;
    for (int i = 1; i <= n; ++i) parts.push_back(part(i, n));
    Random random(static_cast<std::uint64_t>(n));
    for (int order = 0; order < 3; ++order) {
      for (std::size_t i = parts.size() - 1; i > 0; --i) std::swap(parts[i], parts[random.below(i + 1)]);
      const std::string all = folder.file("all.db");
      merge_stores(all, {parts.begin(), parts.begin() + n / 2});
      merge_stores(all, parts);
      CHECK(point_hash_of(all) == one);
      CHECK(merge_stores(all, {whole}).points == 0);
      std::filesystem::remove(all);
    }
  }
  const auto apart = split_store(whole, folder.file("apart"));
  REQUIRE(apart.size() == 1);
  CHECK(point_hash_of(apart[0]) == one);
}

TEST_CASE("points that differ are no one's, and a flipped bit is damage", "[store][points]") {
  const Folder folder;
  const std::string a = folder.file("a.db"), b = folder.file("b.db"), all = folder.file("all.db");
  const auto put = [](const std::string& file, const std::string& content) {
    Points(file, "field").get(0, "x", [&] { return content; });
  };
  put(a, "1"), put(b, "2");
  CHECK_THROWS_WITH(merge_stores(all, {a, b}),
                    Contains("of field is not the same in") && Contains("nothing was merged"));
  CHECK_FALSE(std::filesystem::exists(all));
  change(a, "UPDATE point SET content = x'33'");
  CHECK_THROWS_WITH(put(a, "1"),
                    Contains("the file is damaged: point") && Contains("does not match its checksum"));
  CHECK_THROWS_WITH(merge_stores(all, {a}),
                    Contains("does not match its checksum; restore it from a copy; nothing was merged"));
}

TEST_CASE("content comes back as it was written, to the bit", "[store][points]") {
  const std::string bytes = content_of(3);
  ByteReader in(bytes);
  const std::vector<double> numbers = in.numbers();
  REQUIRE(numbers.size() == 3);
  CHECK(same(numbers[0], Random(3).normal()));
  CHECK(std::isnan(numbers[1]));
  CHECK(same(numbers[2], -0.0));
  CHECK(in.text() == std::string("a\0b", 3));
  CHECK(in.integer() == 3);
}

TEST_CASE("content cut short is an error, whatever it should hold", "[store][points]") {
  const std::string bytes = content_of(1);
  const auto read = [](const std::string& text) {
    ByteReader in(text);
    in.numbers();
    in.text();
    return in.integer();
  };
  CHECK(read(bytes) == 1);
  for (std::size_t n = 0; n < bytes.size(); ++n) CHECK_THROWS_AS(read(bytes.substr(0, n)), StoreError);
  for (const std::int64_t length : {std::int64_t{-1}, std::int64_t{1} << 61, INT64_MAX})
    CHECK_THROWS_AS(read(ByteWriter().add(length).add(1.0).bytes()), StoreError);
}

TEST_CASE("sweeps cut into other blocks are refused, from whichever side", "[store][points]") {
  const Folder folder;
  SweepInfo info;
  info.design = "{}", info.design_hash = "h", info.points = 100, info.columns = "x",
  info.program_version = "1";
  const auto file = [&](const std::string& name, std::int64_t first, std::int64_t count) {
    SweepStore store(folder.file(name));
    store.put(
        store.open_sweep(info),
        std::vector{SweepBlock{first, count, std::vector<double>(static_cast<std::size_t>(count), 1.0)}});
    return folder.file(name);
  };
  const std::string middle = file("m.db", 20, 20), low = file("l.db", 10, 11), high = file("h.db", 39, 5),
                    inside = file("i.db", 25, 5), around = file("a.db", 0, 90), fits = file("f.db", 40, 10);
  for (const std::string& other : {low, high, inside, around}) {
    CHECK_THROWS_WITH(merge_stores(folder.file("x.db"), {middle, other}), Contains("the cut into blocks"));
    CHECK_THROWS_WITH(merge_stores(folder.file("x.db"), {other, middle}), Contains("the cut into blocks"));
  }
  merge_stores(folder.file("x.db"), {middle, fits, middle});
  CHECK(check_store(folder.file("x.db")).sweeps == 1);
}
