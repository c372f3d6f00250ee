#pragma once

#include "host/store/sqlite.h"
#include "host/store/store.h"

namespace powbench::host {

/// Opens the file behind a Store. What must be refused is refused from the raw header, before SQLite touches anything,
/// so that a refused file stays as it was.
sqlite::Database open_store(const std::string& path, Store::Mode mode);

/// Where a file is made aside before it gets its name `path`: path + mark + the process. What one that was killed
/// left there goes first.
std::string aside_file(const std::string& path, const std::string& mark);

/// Gives the finished file `aside` its name; false where another file with content has it already.
bool put_in_place(const std::string& aside, const std::string& path);

/// Rows and indices of one table agree; throws StoreError. Of opening a store: campaign and shot are.
void check_table(const sqlite::Database&, const std::string& table);

}  // namespace powbench::host
