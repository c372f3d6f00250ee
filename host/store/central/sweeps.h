#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/store/central/postgres.h"
#include "host/store/content.h"

/// Sweeps of a store into the database and back, and the hashes by which rows are known there.

namespace powbench::host {

/// Hash of a shot in the database: of its campaign, of all of its row and of its record.
std::string central_shot_key(const std::string& campaign_hash, const StoredShot&, const RecordName&);

class SweepPusher {
 public:
  SweepPusher(const sqlite::Database& from, postgres::Connection& to) : from_(from), to_(to) {}

  /// How many blocks the database lacks. Throws WrongStore where a sweep or a block is not the same.
  std::int64_t compare();
  /// Sends them, some at a time in a transaction under the lock of their sweep; `sent` gets the bytes of each.
  void push(const std::function<void(std::int64_t bytes)>& sent);

 private:
  /// A block without its numbers.
  struct Name {
    std::int64_t first = 0, count = 0;
    std::string hash;
  };
  struct Part {
    SweepInfo sweep;
    std::vector<Name> blocks;  ///< not in the database
  };
  /// Whether the database has this sweep, begun no later.
  bool known(const SweepInfo&) const;
  std::vector<Name> lacking(const SweepInfo&, std::vector<Name>) const;
  void lock(const SweepInfo&);
  [[noreturn]] void conflict(const std::string& what) const;

  const sqlite::Database& from_;
  postgres::Connection& to_;
  std::vector<Part> parts_;
  bool began_ = false;
};

/// All sweeps of the database into a store that has none; returns the number of blocks. Throws StoreError for a block
/// that does not match its hash.
std::int64_t pull_sweeps(postgres::Connection& from, sqlite::Database& to);

}  // namespace powbench::host
