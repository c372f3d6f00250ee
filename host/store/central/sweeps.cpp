#include "host/store/central/sweeps.h"

#include <algorithm>
#include <cstring>
#include <map>

#include "host/store/seal.h"

namespace powbench::host {

using postgres::Rows;
using postgres::Values;

namespace {

/// Blocks a transaction; one of 500 points takes 80 kB.
constexpr std::size_t most_blocks = 64;

/// Hash of a block in the database.
std::string block_key(const SweepBlock& b) {
  Seal seal;
  seal.add(b.first).add(b.count);
  for (const double x : b.numbers) seal.add(x);
  return seal.hex();
}

std::span<const std::uint8_t> bytes_of(const SweepBlock& b) {
  return {reinterpret_cast<const std::uint8_t*>(b.numbers.data()), 8 * b.numbers.size()};
}

}  // namespace

std::string central_shot_key(const std::string& campaign, const StoredShot& s, const RecordName& record) {
  return Seal().add(campaign).add(shot_key(s, record)).hex();
}

void SweepPusher::conflict(const std::string& what) const {
  throw WrongStore(what + " is not the same in " + from_.path() + " and in " + to_.address() + ": " +
                   (began_ ? "the push has stopped there" : "nothing was pushed"));
}

bool SweepPusher::known(const SweepInfo& s) const {
  const Rows there =
      to_.run("SELECT design, points, columns, program_version, created FROM sweep WHERE design_hash = $1",
              Values().text(s.design_hash));
  if (there.size() == 0) return false;
  if (there.text(0, 0) != s.design || there.integer(0, 1) != s.points || there.text(0, 2) != s.columns ||
      there.text(0, 3) != s.program_version)
    conflict("sweep of " + s.created);
  return s.created >= there.text(0, 4);
}

std::vector<SweepPusher::Name> SweepPusher::lacking(const SweepInfo& s, std::vector<Name> blocks) const {
  const std::string what = "sweep of " + s.created;
  struct Known {
    std::int64_t count;
    std::string hash;
  };
  std::map<std::int64_t, Known> all;
  const Rows rows = to_.run(
      "SELECT b.first, b.count, b.hash FROM sweep_block b JOIN sweep s ON s.id = b.sweep_id WHERE "
      "s.design_hash = $1",
      Values().text(s.design_hash));
  for (int i = 0; i < rows.size(); ++i) all[rows.integer(i, 0)] = {rows.integer(i, 1), rows.text(i, 2)};
  std::erase_if(blocks, [&](const Name& b) {
    const auto [at, fresh] = all.try_emplace(b.first, Known{b.count, b.hash});
    if (at->second.count != b.count || at->second.hash != b.hash)
      conflict(what + ": its block " + std::to_string(b.first));
    return !fresh;
  });
  std::int64_t end = 0;
  for (const auto& [first, b] : all) {
    if (first < end) conflict(what + ": the cut into blocks at " + std::to_string(first));
    end = first + b.count;
  }
  return blocks;
}

std::int64_t SweepPusher::compare() {
  std::int64_t all = 0;
  for (const SweepInfo& s : select_sweeps(from_)) {
    const bool there = known(s);
    std::vector<Name> blocks;
    each_block(from_, s.id, [&](const SweepBlock& b) { blocks.push_back({b.first, b.count, block_key(b)}); });
    blocks = lacking(s, std::move(blocks));
    all += static_cast<std::int64_t>(blocks.size());
    if (!there || !blocks.empty()) parts_.push_back({s, std::move(blocks)});
  }
  std::sort(parts_.begin(), parts_.end(),
            [](const Part& a, const Part& b) { return a.sweep.design_hash < b.sweep.design_hash; });
  return all;
}

/// Until the transaction ends. Of equal sweeps the earlier one gives the time.
void SweepPusher::lock(const SweepInfo& s) {
  to_.queue(
      "INSERT INTO sweep (design_hash, created, design, points, columns, program_version) VALUES ($1, $2, "
      "$3, $4, "
      "$5, $6) ON CONFLICT DO NOTHING",
      Values()
          .text(s.design_hash)
          .text(s.created)
          .text(s.design)
          .integer(s.points)
          .text(s.columns)
          .text(s.program_version));
  to_.queue("SELECT id FROM sweep WHERE design_hash = $1 FOR UPDATE", Values().text(s.design_hash));
  to_.queue("UPDATE sweep SET created = $2 WHERE design_hash = $1 AND created COLLATE \"C\" > $2",
            Values().text(s.design_hash).text(s.created));
  to_.finish();
  known(s);
}

void SweepPusher::push(const std::function<void(std::int64_t bytes)>& sent) {
  began_ = true;
  for (const Part& p : parts_) {
    std::size_t first = 0;
    do {  // a sweep without a block is one too
      const std::size_t last = std::min(first + most_blocks, p.blocks.size());
      postgres::Transaction t(to_);
      lock(p.sweep);
      const auto begin = p.blocks.begin();
      const std::vector<Name> fresh = lacking(
          p.sweep, {begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last)});
      std::vector<std::int64_t> sizes;
      for (const Name& name : fresh) {
        // the state of the store is that of compare(), so the block is there and the same
        const SweepBlock b = select_block(from_, p.sweep.id, name.first).value();
        to_.queue(
            "INSERT INTO sweep_block SELECT id, $2, $3, $4, $5 FROM sweep WHERE design_hash = $1 ON CONFLICT "
            "DO "
            "NOTHING",
            Values()
                .text(p.sweep.design_hash)
                .integer(b.first)
                .integer(b.count)
                .text(name.hash)
                .bytes(bytes_of(b)));
        sizes.push_back(static_cast<std::int64_t>(bytes_of(b).size()));
      }
      to_.finish();
      t.commit();
      for (const std::int64_t bytes : sizes) sent(bytes);
      first = last;
    } while (first < p.blocks.size());
  }
}

std::int64_t pull_sweeps(postgres::Connection& from, sqlite::Database& to) {
  std::int64_t blocks = 0;
  const Rows sweeps = from.run(
      "SELECT id, created, design, design_hash, points, columns, program_version FROM sweep ORDER BY "
      "created, "
      "design_hash");
  for (int i = 0; i < sweeps.size(); ++i) {
    const SweepInfo s{0,
                      sweeps.text(i, 1),
                      sweeps.text(i, 2),
                      sweeps.text(i, 3),
                      sweeps.integer(i, 4),
                      sweeps.text(i, 5),
                      sweeps.text(i, 6)};
    sqlite::Transaction t(to);
    const std::int64_t id = insert_sweep(to, s);
    for (std::int64_t after = -1;;) {
      const Rows rows = from.run(
          "SELECT first, count, hash, numbers FROM sweep_block WHERE sweep_id = $1 AND first > $2 ORDER BY "
          "first "
          "LIMIT 64",
          Values().integer(sweeps.integer(i, 0)).integer(after));
      if (rows.size() == 0) break;
      for (int k = 0; k < rows.size(); ++k) {
        SweepBlock b{rows.integer(k, 0), rows.integer(k, 1), {}};
        const auto bytes = rows.bytes(k, 3);
        b.numbers.resize(bytes.size() / 8);
        std::memcpy(b.numbers.data(), bytes.data(), 8 * b.numbers.size());
        if (block_key(b) != rows.text(k, 2))
          throw StoreError(from.address() + ": block " + std::to_string(b.first) + " of the sweep of " +
                           s.created + " does not match its hash: the database is damaged");
        insert_block(to, id, b.first, b.count, b.numbers);
        after = b.first;
        ++blocks;
      }
    }
    t.commit();
  }
  return blocks;
}

}  // namespace powbench::host
