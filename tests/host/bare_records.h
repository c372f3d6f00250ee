#pragma once

#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "host/store/store.h"

/// Records as programs before packing wrote them.

namespace powbench::host {

/// Replaces the packed samples of every record by bare scans: sample by sample, channel by channel, little endian.
inline void unpack_records(const std::string& path) {
  std::vector<std::pair<std::int64_t, std::string>> scans;
  {
    const Store store(path, Store::Mode::read_only);
    for (const CampaignInfo& c : store.campaigns())
      for (const StoredShot& s : store.shots(c.id)) {
        if (s.record_hash.empty()) continue;
        const Record r = store.load_record(s.id);
        std::string bytes;
        for (std::size_t i = 0; i < r.samples(); ++i)
          for (const ChannelRecord& c2 : r.channels) {
            const auto v = static_cast<std::uint16_t>(c2.raw[i]);
            bytes += static_cast<char>(v & 0xFFU);
            bytes += static_cast<char>(v >> 8);
          }
        scans.emplace_back(s.id, std::move(bytes));
      }
  }
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &db) == SQLITE_OK);
  for (const auto& [shot, bytes] : scans) {
    sqlite3_stmt* s = nullptr;
    REQUIRE(sqlite3_prepare_v2(db, "UPDATE record SET packing = '', scans = ? WHERE shot_id = ?", -1, &s,
                               nullptr) == SQLITE_OK);
    sqlite3_bind_blob(s, 1, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
    sqlite3_bind_int64(s, 2, shot);
    CHECK(sqlite3_step(s) == SQLITE_DONE);
    sqlite3_finalize(s);
  }
  sqlite3_close(db);
}

}  // namespace powbench::host
