#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "host/store/sqlite.h"
#include "host/store/sweep_store.h"

/// Rows of sweeps and their seals. Readers throw StoreError for a row that does not match.

namespace powbench::host {

std::vector<SweepInfo> select_sweeps(const sqlite::Database&);
std::int64_t insert_sweep(sqlite::Database&, const SweepInfo&);

/// The earlier of two equal sweeps gives the time.
void set_sweep_created(sqlite::Database&, SweepInfo, const std::string& created);

std::optional<SweepBlock> select_block(const sqlite::Database&, std::int64_t sweep, std::int64_t first);
/// Is a point of first .. first + count - 1 in another block? Blocks with this very `first` are not looked at.
bool overlaps_block(const sqlite::Database&, std::int64_t sweep, std::int64_t first, std::int64_t count);

/// In ascending order, one block in memory at a time: a sweep may be larger than the memory.
void each_block(const sqlite::Database&, std::int64_t sweep, const std::function<void(SweepBlock)>& look);
/// A block that is there already is kept as it is.
void insert_block(sqlite::Database&, std::int64_t sweep, std::int64_t first, std::int64_t count,
                  std::span<const double> numbers);

}  // namespace powbench::host
