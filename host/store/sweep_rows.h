#pragma once

#include <span>
#include <vector>

#include "host/store/sqlite.h"
#include "host/store/sweep_store.h"

/// Rows of sweeps and their seals. Readers throw StoreError for a row that does not match.

namespace powbench::host {

std::vector<SweepInfo> select_sweeps(const sqlite::Database&);
std::int64_t insert_sweep(sqlite::Database&, const SweepInfo&);

/// In ascending order.
std::vector<SweepBlock> select_blocks(const sqlite::Database&, std::int64_t sweep);
/// A block that is there already is kept as it is.
void insert_block(sqlite::Database&, std::int64_t sweep, std::int64_t first, std::int64_t count,
                  std::span<const double> numbers);

}  // namespace powbench::host
