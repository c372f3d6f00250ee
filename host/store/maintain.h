#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

/// Whole stores: check, bring up to date, put together, take apart.

namespace powbench::host {

struct StoreContent {
  std::int64_t campaigns = 0, shots = 0, records = 0, events = 0, sweeps = 0, points = 0;
  std::int64_t bare = 0;            ///< records that are not packed
  std::int64_t undigested = 0;      ///< shots with events but without the short row for lists
  std::string hash;                 ///< SHA-256 of all content, whatever the order of its rows and their ids
  std::vector<std::string> damage;  ///< a sentence each, the first twenty; then `hash` is empty
};

using Step = std::function<void(std::int64_t done, std::int64_t all)>;  ///< shots

/// Reads all of it: structure, indices, the seal of every row, the samples of every record, and whether the digests
/// are those of the events. Throws StoreError only where the file cannot be opened; what is wrong inside is listed.
StoreContent check_store(const std::string& path, const Step& = {});

struct Migrated {
  std::int64_t packed = 0, digested = 0;
};
/// Schema, packing of records, digests for lists: what an older store lacks. The content hash stays the same.
/// Interrupted, it goes on where it stopped. With `compact`, gives free pages back (needs room for a copy).
Migrated migrate_store(const std::string& path, bool compact, const Step& = {});

struct Merged {
  std::int64_t campaigns = 0, shots = 0, events = 0, sweep_blocks = 0, points = 0;  ///< added
};
/// Adds what `sources` hold to `target`, made if missing; sources stay as they are. In one transaction: all or
/// nothing. The same campaign (all of its row equal) is one, the same shot (number, kind, attempt) too. Order,
/// grouping and repetition of the sources do not matter for the content. Throws StoreError, and leaves the target as
/// it was, where a source is damaged or two differ in what is there once: a shot, its events, a prediction, a block
/// of a sweep, a point.
Merged merge_stores(const std::string& target, const std::vector<std::string>& sources);

/// Writes every campaign (or only `campaign`, if not 0) to a store of its own, FOLDER/campaign-ID.db, and sweeps and
/// points to FOLDER/sweeps.db; returns the files. Throws StoreError where one of them is there already.
std::vector<std::string> split_store(const std::string& path, const std::string& folder,
                                     std::int64_t campaign = 0);

}  // namespace powbench::host
