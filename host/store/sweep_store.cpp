#include "host/store/sweep_store.h"

#include <bit>
#include <cstring>

#include "host/store/open.h"
#include "host/store/rows.h"
#include "host/store/seal.h"
#include "host/store/sweep_rows.h"

namespace powbench::host {

using sqlite::Database;
using sqlite::Statement;
using sqlite::Transaction;

static_assert(std::endian::native == std::endian::little, "blobs hold little-endian numbers");

namespace {

std::string seal_of(const SweepInfo& s) {
  return Seal()
      .add(s.created)
      .add(s.design)
      .add(s.design_hash)
      .add(s.points)
      .add(s.columns)
      .add(s.program_version)
      .hex();
}

std::string seal_of(std::int64_t sweep, std::int64_t first, std::int64_t count,
                    std::span<const std::uint8_t> bytes) {
  return Seal()
      .add(sweep)
      .add(first)
      .add(count)
      .add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()))
      .hex();
}

[[noreturn]] void damaged(const std::string& what) {
  throw StoreError("the file is damaged: " + what + " does not match its checksum; restore it from a copy");
}

}  // namespace

std::vector<SweepInfo> select_sweeps(const Database& db) {
  std::vector<SweepInfo> list;
  Statement s(db,
              "SELECT id, created, design, design_hash, points, columns, program_version, seal FROM sweep "
              "ORDER BY id");
  while (s.step()) {
    list.push_back({s.integer(0), s.text(1), s.text(2), s.text(3), s.integer(4), s.text(5), s.text(6)});
    if (seal_of(list.back()) != s.text(7)) damaged("sweep " + std::to_string(list.back().id));
  }
  return list;
}

std::int64_t insert_sweep(Database& db, const SweepInfo& info) {
  Statement(db,
            "INSERT INTO sweep (created, design, design_hash, points, columns, program_version, seal) "
            "VALUES (?, ?, ?, ?, ?, ?, ?)")
      .bind(info.created)
      .bind(info.design)
      .bind(info.design_hash)
      .bind(info.points)
      .bind(info.columns)
      .bind(info.program_version)
      .bind(seal_of(info))
      .run();
  return db.last_id();
}

void insert_block(Database& db, std::int64_t sweep, std::int64_t first, std::int64_t count,
                  std::span<const double> numbers) {
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(numbers.data()),
                                            numbers.size_bytes());
  Statement(
      db, "INSERT OR IGNORE INTO sweep_block (sweep_id, first, count, seal, numbers) VALUES (?, ?, ?, ?, ?)")
      .bind(sweep)
      .bind(first)
      .bind(count)
      .bind(seal_of(sweep, first, count, bytes))
      .bind_blob(bytes)
      .run();
}

namespace {

/// Columns first, count, seal, numbers.
SweepBlock block_row(const Statement& s, std::int64_t sweep) {
  SweepBlock b{s.integer(0), s.integer(1), {}};
  const auto bytes = s.blob(3);
  if (seal_of(sweep, b.first, b.count, bytes) != s.text(2))
    damaged("block " + std::to_string(b.first) + " of sweep " + std::to_string(sweep));
  b.numbers.resize(bytes.size() / sizeof(double));
  std::memcpy(b.numbers.data(), bytes.data(), b.numbers.size() * sizeof(double));
  return b;
}

}  // namespace

void set_sweep_created(Database& db, SweepInfo sweep, const std::string& created) {
  sweep.created = created;
  Statement(db, "UPDATE sweep SET created = ?, seal = ? WHERE id = ?")
      .bind(created)
      .bind(seal_of(sweep))
      .bind(sweep.id)
      .run();
}

std::optional<SweepBlock> select_block(const Database& db, std::int64_t sweep, std::int64_t first) {
  Statement s(db, "SELECT first, count, seal, numbers FROM sweep_block WHERE sweep_id = ? AND first = ?");
  s.bind(sweep).bind(first);
  if (!s.step()) return std::nullopt;
  return block_row(s, sweep);
}

bool overlaps_block(const Database& db, std::int64_t sweep, std::int64_t first, std::int64_t count) {
  Statement before(
      db,
      "SELECT first + count FROM sweep_block WHERE sweep_id = ? AND first < ? ORDER BY first DESC LIMIT 1");
  if (before.bind(sweep).bind(first).step() && before.integer(0) > first) return true;
  Statement behind(db,
                   "SELECT first FROM sweep_block WHERE sweep_id = ? AND first > ? ORDER BY first LIMIT 1");
  return behind.bind(sweep).bind(first).step() && behind.integer(0) < first + count;
}

void each_block(const Database& db, std::int64_t sweep, const std::function<void(SweepBlock)>& look) {
  Statement s(db, "SELECT first, count, seal, numbers FROM sweep_block WHERE sweep_id = ? ORDER BY first");
  s.bind(sweep);
  while (s.step()) look(block_row(s, sweep));
}

struct SweepStore::Impl {
  Database db;
};

SweepStore::SweepStore(const std::string& path)
    : impl_(new Impl{open_store(path, Store::Mode::read_write)}) {}
SweepStore::~SweepStore() = default;

std::int64_t SweepStore::open_sweep(const SweepInfo& given) {
  Transaction t(impl_->db);
  for (const auto& s : sweeps())
    if (s.design_hash == given.design_hash) return s.id;
  SweepInfo info = given;
  info.created = utc_now();
  const std::int64_t id = insert_sweep(impl_->db, info);
  t.commit();
  return id;
}

std::vector<SweepInfo> SweepStore::sweeps() const {
  return select_sweeps(impl_->db);
}

void SweepStore::put(std::int64_t sweep, std::span<const SweepBlock> blocks) {
  Transaction t(impl_->db);
  for (const SweepBlock& b : blocks) insert_block(impl_->db, sweep, b.first, b.count, b.numbers);
  t.commit();
}

std::vector<SweepBlock> SweepStore::blocks(std::int64_t sweep) const {
  std::vector<SweepBlock> list;
  each_block(impl_->db, sweep, [&](SweepBlock b) { list.push_back(std::move(b)); });
  return list;
}

}  // namespace powbench::host
