#pragma once

#include "core/record.h"
#include "host/store/sqlite.h"

namespace powbench::host {

/// Writes record and channels of a shot; returns the record's id. Samples go in as one blob, 2 bytes a value.
std::int64_t insert_record(sqlite::Database&, std::int64_t shot, const Record&);

/// Reads them back (without conditions). Throws StoreError when the samples do not match their hash.
Record select_record(const sqlite::Database&, std::int64_t shot);

}  // namespace powbench::host
