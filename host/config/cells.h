#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Lines and cells of a text with separated columns.

namespace powbench::host {

/// Without blanks, tabs and NULs at either end.
std::string_view trimmed_cell(std::string_view);

/// A cell for messages: short, printable.
std::string shown_cell(std::string_view);

/// The lines of a text, whatever ends them.
class Lines {
 public:
  explicit Lines(std::string_view all) : left_(all) {}
  bool next();
  std::string_view text;
  int number = 0;  ///< 1-based

 private:
  std::string_view left_;
};

/// Empty, or begins with `#`.
bool says_nothing(std::string_view line);

/// Cells of one line. False when a quote stays open.
bool split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// An empty cell, nan, na, n/a, null, -, in any case.
bool is_missing(std::string_view cell);

/// The whole cell as a number, or nothing. Beyond the range of doubles: infinity, or 0.
std::optional<double> cell_number(std::string_view cell, bool decimal_comma);

/// Magnitudes from here on are over-range codes of instruments (SCPI: 9.9E37 stands for infinity, 9.91E37 for not a
/// number).
inline constexpr double over_range_code = 9.9e37;

/// Refuses, by BadInput, UTF-16 and binary data; returns the text without the UTF-8 byte order mark.
std::string_view plain_text(std::string_view text, const std::string& file);

}  // namespace powbench::host
