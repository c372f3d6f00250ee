#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "host/store/field_table.h"
#include "host/store/store.h"
#include "tests/end_ring.h"

using namespace powbench;
namespace fs = std::filesystem;

namespace {

sim::PotentialTable small_table() {
  sim::PotentialTable t;
  t.psi = {0, 0.5, 1};
  t.gap = {0, 1e-3};
  for (std::size_t g = 0; g < t.gap.size(); ++g) {
    const double stiffness = 10 + 5e3 * t.gap[g];
    for (const double psi : t.psi)
      t.nodes.insert(t.nodes.end(),
                     {0.5 * stiffness * psi * psi, stiffness * psi, 2.5e3 * psi * psi, 5e3 * psi});
    t.air.insert(t.air.end(), {50 + 5e3 * t.gap[g], 5e3});
  }
  t.current_error = {1e-3, 2e-3};
  t.pull_error = {1e-4, 3e-4};
  t.mesh_error = 2e-3;
  t.steel_field = {0, 0.8, 1.7, 0, 0.7, 1.5};
  t.data_end = 1.6;
  t.design_hash = 0x0123456789abcdefULL;
  t.description = "three by two";
  return t;
}

struct Folder {
  fs::path path = fs::temp_directory_path() / "powbench-field-table-test";
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
};

}  // namespace

TEST_CASE("a field table comes back from the disk bit by bit") {
  const Folder folder;
  const auto t = small_table();
  host::save_field_table(folder.path / "a.table", t);
  const auto r = host::load_field_table(folder.path / "a.table");
  CHECK(r.psi == t.psi);
  CHECK(r.ring.empty());
  CHECK(r.gap == t.gap);
  CHECK(r.nodes == t.nodes);
  CHECK(r.air == t.air);
  CHECK(r.pull_error == t.pull_error);
  CHECK(r.mesh_error == t.mesh_error);
  CHECK(r.steel_field == t.steel_field);
  CHECK(r.data_end == t.data_end);
  CHECK(r.design_hash == t.design_hash);
  CHECK(r.description == t.description);
  CHECK(std::distance(fs::directory_iterator(folder.path), {}) == 1);
}

TEST_CASE("a field table with a ring keeps what its axes mean") {
  auto t = small_table();
  t.ring = {-1e-4, 1e-4};
  t.ring_ratio = 1500;
  t.nodes.assign(t.psi.size() * t.ring.size() * t.gap.size() * t.values(), 1);
  t.air.assign(4 * t.gap.size(), 1);
  t.steel_field.clear();
  const auto r = host::parse_field_table(host::field_table_bytes(t), "x.table");
  CHECK(r.ring == t.ring);
  CHECK(r.ring_ratio == t.ring_ratio);
  CHECK(r.largest_psi() == 1.15);
  auto without = small_table();
  without.ring_ratio = 1;
  CHECK_THROWS_WITH(sim::check_table(without), Catch::Matchers::Contains("ring_ratio"));
}

TEST_CASE("a damaged field table is told with its name and its fault") {
  using Catch::Matchers::Contains;
  const std::string good = host::field_table_bytes(small_table());
  const auto parse = [](const std::string& bytes) { return host::parse_field_table(bytes, "x.table"); };
  CHECK_NOTHROW(parse(good));
  for (const std::size_t at : {good.size() / 3, good.size() / 2, good.size() - 1}) {
    auto bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    CHECK_THROWS_WITH(parse(bad), Contains("x.table") && Contains("checksum"));
  }
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, std::size_t{30}, good.size() - 8})
    CHECK_THROWS_AS(parse(good.substr(0, length)), host::StoreError);
  auto other = good;
  other[other.find(" 3\n") + 1] = '7';
  CHECK_THROWS_WITH(parse(other), Contains("version"));
  CHECK_THROWS_WITH(parse("hello"), Contains("not a table"));
  CHECK_THROWS_AS(host::load_field_table("/nowhere/at/all.table"), host::StoreError);
}

TEST_CASE("a table is built once for a design and found again") {
  const Folder folder;
  sim::MagnetDesign design;
  sim::TableOptions options;
  options.accuracy = 0.05;
  options.ring = false;
  options.psi_nodes = options.gap_nodes = 6;
  sim::Team team(2);
  const auto first = host::obtain_field_table(folder.path, design, options, team);
  const auto second = host::obtain_field_table(folder.path, design, options, team);
  CHECK_FALSE(first.reused);
  CHECK(second.reused);
  CHECK(first.table.nodes == second.table.nodes);
  design.turns += 1;
  CHECK_FALSE(host::obtain_field_table(folder.path, design, options, team).reused);
}

TEST_CASE("a table with ends and ring is stored, found again, and obeys what both must", "[.slow]") {
  const Folder folder;
  sim::MagnetDesign design;  // its edges on few planes, so that few cells hold it
  auto& s = design.shape;
  s.coil_width = s.window_width;
  s.coil_offset = 0;
  s.coil_height = s.fixed_window - s.ring_depth - 0.1e-6;
  sim::TableOptions options;
  options.accuracy = 0.05;
  options.psi_nodes = 12, options.ring_nodes = 11, options.gap_nodes = 5;
  options.largest_gap = 2e-3;
  options.largest_field = 1.8;
  sim::EndTableOptions ends;
  ends.sizes = {.corner = 6e-3, .other = 12e-3, .largest = 20e-3, .far = 100e-3, .growth = 5};
  ends.sizes.layers = 2;
  ends.psi_nodes = 7, ends.ring_nodes = 5, ends.gap_nodes = 4;
  sim::Team team(2);
  const auto first = host::obtain_end_table(folder.path, design, options, ends, team);
  CHECK_FALSE(first.reused);
  CHECK(host::obtain_end_table(folder.path, design, options, ends, team).reused);
  const auto plane = host::obtain_field_table(folder.path, design, options, team);
  CHECK(plane.file != first.file);
  test::check_ends_with_ring(sim::TablePotential(host::load_field_table(first.file)),
                             sim::TablePotential(plane.table));
}
