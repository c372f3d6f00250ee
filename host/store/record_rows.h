#pragma once

#include "core/record.h"
#include "host/store/sqlite.h"

namespace powbench::host {

/// Writes record and channels of a shot; returns the record's id. Samples go in as one packed blob (packing.h).
std::int64_t insert_record(sqlite::Database&, std::int64_t shot, const Record&);

/// Reads them back (without conditions). Throws StoreError when the samples do not match their hash.
Record select_record(const sqlite::Database&, std::int64_t shot);

/// Packs the samples of a record from before they were; true: it was bare. Its hash and its seal stay as they are.
bool pack_record(sqlite::Database&, std::int64_t shot);

}  // namespace powbench::host
