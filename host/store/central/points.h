#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/store/central/postgres.h"
#include "host/store/point_rows.h"

/// Points of studies from a store into the database and back.

namespace powbench::host {

class PointPusher {
 public:
  PointPusher(const sqlite::Database& from, postgres::Connection& to) : from_(from), to_(to) {}

  /// How many points the database lacks. Throws WrongStore where it has another content under the same id.
  std::int64_t compare();
  /// Sends them, some at a time in a transaction, in the order of their ids; `sent` gets the bytes of each.
  void push(const std::function<void(std::int64_t bytes)>& sent);

 private:
  /// Those of the rows that the database lacks.
  std::vector<PointRow> lacking(std::vector<PointRow>) const;
  void send(const std::vector<PointRow>&);

  const sqlite::Database& from_;
  postgres::Connection& to_;
  std::vector<std::string> ids_;  ///< not in the database
  bool began_ = false;
};

/// All points of the database into a store that has none; returns their number. Throws StoreError for one that does
/// not match its hash.
std::int64_t pull_points(postgres::Connection& from, sqlite::Database& to);

}  // namespace powbench::host
