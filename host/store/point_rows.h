#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/store/sqlite.h"

/// Rows of points and their seals. Readers throw StoreError for a row that does not match.

namespace powbench::host {

struct PointRow {
  std::string id, study, content;
};
std::optional<PointRow> select_point(const sqlite::Database&, const std::string& id);
/// All, by id.
void each_point(const sqlite::Database&, const std::function<void(const PointRow&)>&);
/// One that is there already is kept as it is.
void insert_point(sqlite::Database&, const PointRow&);
/// Of id and content.
std::string point_hash(const PointRow&);

}  // namespace powbench::host
