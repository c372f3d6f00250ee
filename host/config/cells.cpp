#include "host/config/cells.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>

#include "host/config/bad_input.h"

namespace powbench::host {

std::string_view trimmed_cell(std::string_view s) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\0'; };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

std::string shown_cell(std::string_view cell) {
  std::string text;
  for (const char c : cell.substr(0, 40)) text += c >= ' ' && c != 0x7F ? c : '?';
  return "'" + text + (cell.size() > 40 ? "...'" : "'");
}

bool Lines::next() {
  if (left_.empty()) return false;
  const std::size_t end = std::min(left_.find_first_of("\r\n"), left_.size());
  text = left_.substr(0, end);
  left_.remove_prefix(end);
  if (left_.starts_with("\r\n"))
    left_.remove_prefix(2);
  else if (!left_.empty())
    left_.remove_prefix(1);
  ++number;
  return true;
}

bool says_nothing(std::string_view line) {
  const auto t = trimmed_cell(line);
  return t.empty() || t.front() == '#';
}

bool split_cells(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    std::string_view rest = line;
    while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    if (!rest.empty() && rest.front() == '"') {
      const std::size_t close = rest.find('"', 1);
      if (close == std::string_view::npos) return false;
      cells.push_back(trimmed_cell(rest.substr(1, close - 1)));
      const std::size_t end = rest.find(separator, close);
      if (end == std::string_view::npos) return true;
      line = rest.substr(end + 1);
      continue;
    }
    const std::size_t end = line.find(separator);
    cells.push_back(trimmed_cell(line.substr(0, end)));
    if (end == std::string_view::npos) return true;
    line.remove_prefix(end + 1);
  }
}

bool is_missing(std::string_view cell) {
  if (cell.empty()) return true;
  if (cell.size() > 4) return false;
  std::string word;
  for (const char c : cell) word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word == "nan" || word == "na" || word == "n/a" || word == "null" || word == "-" || word == "-nan" ||
         word == "+nan";
}

std::optional<double> cell_number(std::string_view cell, bool decimal_comma) {
  char buffer[64];
  if (cell.starts_with('+')) cell.remove_prefix(1);
  if (cell.empty() || cell.front() == '+' || cell.size() >= sizeof buffer) return std::nullopt;
  if (decimal_comma) {
    const bool both = cell.find(',') != std::string_view::npos && cell.find('.') != std::string_view::npos;
    if (both) return std::nullopt;  // a thousands separator: no way to tell which is which
    std::replace_copy(cell.begin(), cell.end(), buffer, ',', '.');
    cell = {buffer, cell.size()};
  }
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (end != cell.data() + cell.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range)  // too large, or too small to tell from zero
    return cell.find("e-") != std::string_view::npos || cell.find("E-") != std::string_view::npos
               ? 0.0
               : std::numeric_limits<double>::infinity();
  if (error != std::errc()) return std::nullopt;
  return value;
}

std::string_view plain_text(std::string_view text, const std::string& file) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw BadInput({file + ":1: the text is UTF-16; allowed UTF-8 or ASCII: save it as CSV UTF-8"});
  if (text.starts_with("PK\x03\x04") || text.starts_with("\xD0\xCF\x11\xE0"))
    throw BadInput(
        {file +
         ":1: a workbook or archive (xlsx, ods, xls, zip), binary data; allowed a CSV text: open it in "
         "Excel and save the sheet as CSV UTF-8"});
  if (text.substr(0, 4096).find('\0') != std::string_view::npos)
    throw BadInput(
        {file +
         ":1: not a text but binary data; allowed a CSV text, or of binary files "
         "TDMS (.tdms), MAT 5 (.mat), WAV (.wav), Yokogawa (.wvf with .hdr), COMTRADE (.cfg with .dat, "
         ".cff)"});
  return text;
}

}  // namespace powbench::host
