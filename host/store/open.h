#pragma once

#include "host/store/sqlite.h"
#include "host/store/store.h"

namespace powbench::host {

/// Opens the file behind a Store. What must be refused is refused from the raw header, before SQLite touches anything,
/// so that a refused file stays as it was.
sqlite::Database open_store(const std::string& path, Store::Mode mode);

/// Rows and indices of one table agree; throws StoreError. Of opening a store: campaign and shot are.
void check_table(const sqlite::Database&, const std::string& table);

}  // namespace powbench::host
