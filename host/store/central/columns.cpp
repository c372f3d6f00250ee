#include "host/store/central/columns.h"

namespace powbench::host {

std::string column_list(std::span<const StoreColumn> columns, const std::string& prefix) {
  std::string list;
  for (const StoreColumn& c : columns) list += (list.empty() ? "" : ", ") + prefix + c.name;
  return list;
}

std::string insert_text(const char* table, const char* key, std::span<const StoreColumn> columns,
                        bool numbered) {
  std::string marks;
  for (std::size_t i = 0; i <= columns.size(); ++i)
    marks += (i == 0 ? "" : ", ") + (numbered ? "$" + std::to_string(i + 1) : std::string("?"));
  return std::string("INSERT INTO ") + table + " (" + key + ", " + column_list(columns) + ") VALUES (" +
         marks + ")";
}

void take_columns(postgres::Values& values, const sqlite::Statement& row,
                  std::span<const StoreColumn> columns) {
  int i = 0;
  for (const StoreColumn& c : columns) {
    switch (c.kind) {
      case ColumnKind::integer:
        values.integer(row.integer(i));
        break;
      case ColumnKind::real:
        values.real(row.real(i));
        break;
      case ColumnKind::text:
        values.text(row.text(i));
        break;
      case ColumnKind::bytes:
        values.bytes(row.blob(i));
        break;
    }
    ++i;
  }
}

void give_columns(sqlite::Statement& to, const postgres::Rows& rows, int row, int first,
                  std::span<const StoreColumn> columns) {
  int i = first;
  for (const StoreColumn& c : columns) {
    switch (c.kind) {
      case ColumnKind::integer:
        to.bind(rows.integer(row, i));
        break;
      case ColumnKind::real:
        to.bind(rows.real(row, i));
        break;
      case ColumnKind::text:
        to.bind(rows.text(row, i));
        break;
      case ColumnKind::bytes:
        to.bind_blob(rows.bytes(row, i));
        break;
    }
    ++i;
  }
}

}  // namespace powbench::host
