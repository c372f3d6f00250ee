#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/store/sqlite.h"
#include "host/store/store.h"

/// Rows of table `begun`: shots that are being fired. Readers throw StoreError for a row that does not match its seal.

namespace powbench::host {

/// The program that fires.
struct Firer {
  std::string machine;  ///< its host name
  std::int64_t process = 0;
};
Firer this_program();

/// Replaces what was begun of the same campaign and number.
void insert_begun(sqlite::Database&, const StoredShot&, const Firer& = this_program());
void remove_begun(sqlite::Database&, std::int64_t campaign, int number);

struct BegunRow {
  StoredShot shot;       ///< outcome, reason, id and attempt are not of a row
  bool running = false;  ///< another program fires it, as far as can be known, and for a day at most
};
std::vector<BegunRow> select_begun(const sqlite::Database&);

}  // namespace powbench::host
