#pragma once

#include <array>
#include <span>
#include <string>

#include "host/store/central/postgres.h"
#include "host/store/sqlite.h"

/// Rows that travel as they stand, from SQLite to PostgreSQL and back.

namespace powbench::host {

enum class ColumnKind { integer, real, text, bytes };
struct StoreColumn {
  const char* name;
  ColumnKind kind;
};

inline constexpr std::array<StoreColumn, 16> record_columns{{{"content_hash", ColumnKind::text},
                                                             {"sample_rate", ColumnKind::real},
                                                             {"samples", ColumnKind::integer},
                                                             {"fire_sample", ColumnKind::integer},
                                                             {"fire_offset", ColumnKind::real},
                                                             {"gaps", ColumnKind::text},
                                                             {"overruns", ColumnKind::integer},
                                                             {"crc32", ColumnKind::integer},
                                                             {"rig_shot_id", ColumnKind::integer},
                                                             {"rig", ColumnKind::text},
                                                             {"firmware", ColumnKind::text},
                                                             {"calibration", ColumnKind::text},
                                                             {"seal", ColumnKind::text},
                                                             {"sealed", ColumnKind::text},
                                                             {"packing", ColumnKind::text},
                                                             {"scans", ColumnKind::bytes}}};

inline constexpr std::array<StoreColumn, 9> channel_columns{{{"position", ColumnKind::integer},
                                                             {"name", ColumnKind::text},
                                                             {"unit", ColumnKind::text},
                                                             {"scale", ColumnKind::real},
                                                             {"\"offset\"", ColumnKind::real},
                                                             {"delay", ColumnKind::real},
                                                             {"corner_hertz", ColumnKind::real},
                                                             {"clip_low", ColumnKind::integer},
                                                             {"clip_high", ColumnKind::integer}}};

/// Names with commas between, each behind `prefix`.
std::string column_list(std::span<const StoreColumn>, const std::string& prefix = "");
/// INSERT of `key` and the columns, with marks `?` (SQLite) or `$1` (PostgreSQL).
std::string insert_text(const char* table, const char* key, std::span<const StoreColumn>, bool numbered);
/// The first columns of a row of SQLite as values of PostgreSQL.
void take_columns(postgres::Values&, const sqlite::Statement&, std::span<const StoreColumn>);
/// Columns of a row of PostgreSQL from `first` on into SQLite; the row must live until step().
void give_columns(sqlite::Statement&, const postgres::Rows&, int row, int first,
                  std::span<const StoreColumn>);

}  // namespace powbench::host
