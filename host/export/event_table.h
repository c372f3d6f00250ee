#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

/// Tables with named columns, as other programs read them.

namespace powbench::host {

struct TableColumn {
  std::string name;  ///< with its unit behind the last underscore where it has one: `t_ct1_s`
  std::variant<std::vector<std::int64_t>, std::vector<double>, std::vector<std::string>>
      values;  ///< NaN: not known
};
using Table = std::vector<TableColumn>;  ///< all columns equally long

inline std::size_t rows(const Table& t) {
  return t.empty() ? 0 : std::visit([](const auto& v) { return v.size(); }, t.front().values);
}

/// Arrow IPC file (format 1.0, metadata V5): one record batch, int64, float64 (null where not known) and utf8
/// columns; `about` is kept as the schema's metadata.
std::string to_arrow(const Table&, const std::vector<std::pair<std::string, std::string>>& about = {});

struct Sheet {
  std::string name;  ///< up to 31 characters, none of []:*?/\ in it
  Table table;
};
/// Excel workbook: a header row, then the rows; an unknown number is an empty cell; numbers carry as many digits as
/// the double needs. Throws BadInput where a sheet has more rows or columns than Excel takes (1 048 576, 16 384).
std::string to_xlsx(const std::vector<Sheet>&);

}  // namespace powbench::host
