#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// Text with separated columns, as oscilloscopes, loggers and spreadsheets write it, as numbers.

namespace powbench::host {

struct CsvTable {
  std::vector<std::string> header;           ///< cells of the header line, trimmed, without quotes
  int header_line = 1;                       ///< 1-based
  std::vector<std::vector<double>> columns;  ///< (columns, rows); NaN where a cell holds no number
  std::vector<std::uint32_t> line;           ///< (rows) line of the file, 1-based
  std::vector<double> delay;                 ///< s, of each column; empty: none
  std::vector<std::string> notes;            ///< what the file left open and how it was taken
  std::size_t over_range = 0;                ///< cells with an infinity or an instrument's over-range code

  std::size_t rows() const { return line.size(); }
};

/// Largest number of rows taken.
inline constexpr std::size_t most_rows = 20'000'000;

/// One header line, then one line a sample. Understood:
/// - comma, semicolon or tab between the cells; decimal comma where the separator is not a comma;
/// - line ends LF, CRLF or CR; a UTF-8 byte order mark; empty lines and lines that begin with `#` anywhere;
/// - cells in double quotes; blanks around cells; one empty cell at the end of each line;
/// - no value: an empty cell, nan, na, n/a, null, -, in any case. inf and magnitudes from 9.9e37 on (the over-range
///   codes of instruments) count as no value too and are counted in `over_range`.
/// All else is refused: throws BadInput with the first mistakes, each with `file`, line, column, value and what is
/// allowed.
CsvTable read_csv(std::string_view text, const std::string& file);

}  // namespace powbench::host
