#include "host/config/csv_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "host/config/bad_input.h"

namespace powbench::host {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double over_range_code = 9.9e37;  // SCPI: 9.9E37 stands for infinity, 9.91E37 for not a number
constexpr std::size_t most_mistakes = 10;

std::string_view trimmed(std::string_view s) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\0'; };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

/// A cell for messages: short, printable.
std::string shown(std::string_view cell) {
  std::string text;
  for (const char c : cell.substr(0, 40)) text += c >= ' ' && c != 0x7F ? c : '?';
  return "'" + text + (cell.size() > 40 ? "...'" : "'");
}

/// The lines of a text, whatever ends them.
class Lines {
 public:
  explicit Lines(std::string_view all) : left_(all) {}
  bool next() {
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
  std::string_view text;
  int number = 0;

 private:
  std::string_view left_;
};

bool says_nothing(std::string_view line) {
  const auto t = trimmed(line);
  return t.empty() || t.front() == '#';
}

/// Cells of one line. False when a quote stays open.
bool split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    std::string_view rest = line;
    while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    if (!rest.empty() && rest.front() == '"') {
      const std::size_t close = rest.find('"', 1);
      if (close == std::string_view::npos) return false;
      cells.push_back(trimmed(rest.substr(1, close - 1)));
      const std::size_t end = rest.find(separator, close);
      if (end == std::string_view::npos) return true;
      line = rest.substr(end + 1);
      continue;
    }
    const std::size_t end = line.find(separator);
    cells.push_back(trimmed(line.substr(0, end)));
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

/// The whole cell as a number, or nothing.
std::optional<double> number(std::string_view cell, bool decimal_comma) {
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

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : file_(file), lines_(check(text)) {}

  CsvTable read() {
    read_header();
    while (mistakes_.size() < most_mistakes && lines_.next())
      if (!says_nothing(lines_.text)) read_row();
    if (!mistakes_.empty()) throw BadInput(mistakes_);
    return std::move(table_);
  }

 private:
  std::string_view check(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
      throw BadInput({file_ + ":1: the text is UTF-16; allowed UTF-8 or ASCII: save it as CSV UTF-8"});
    if (text.substr(0, 4096).find('\0') != std::string_view::npos)
      throw BadInput({file_ + ":1: not a text but binary data; allowed a CSV text"});
    return text;
  }

  void fail(const std::string& what) {
    mistakes_.push_back(file_ + ":" + std::to_string(lines_.number) + ": " + what);
  }
  [[noreturn]] void stop(const std::string& what) {
    fail(what);
    throw BadInput(mistakes_);
  }

  void read_header() {
    for (;;) {
      if (!lines_.next())
        throw BadInput({file_ + ":1: the file is empty; allowed a header line such as "
                                "`time [s],pvdf_a [N]` and one line a sample"});
      if (!says_nothing(lines_.text)) break;
    }
    const std::string_view line = lines_.text;
    const auto has = [&](char c) { return line.find(c) != std::string_view::npos; };
    separator_ = has(';') ? ';' : has('\t') ? '\t' : ',';
    if (!split(line, separator_, cells_)) stop("a quote is not closed; allowed cells in pairs of quotes");
    if (cells_.size() > 1 && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() > 64)
      stop("the header has " + std::to_string(cells_.size()) + " columns; allowed 2..64");
    for (const auto cell : cells_) table_.header.emplace_back(cell);
    table_.header_line = lines_.number;
    table_.columns.resize(cells_.size());
  }

  void read_row() {
    const std::size_t columns = table_.columns.size();
    if (table_.rows() >= most_rows)
      stop("more than " + std::to_string(most_rows) + " samples; allowed up to that: cut the file");
    if (!split(lines_.text, separator_, cells_))
      return fail("a quote is not closed; allowed cells in pairs of quotes");
    if (cells_.size() == columns + 1 && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() != columns) {
      std::string hint;
      if (separator_ == ',' && cells_.size() > columns)
        hint = "; where the decimal sign is a comma, put semicolons between the columns";
      else if (cells_.size() < columns)
        hint = "; leave a cell empty where there is no value";
      return fail("the line has " + std::to_string(cells_.size()) + " cells; allowed " +
                  std::to_string(columns) + ", as in the header" + hint);
    }
    table_.line.push_back(static_cast<std::uint32_t>(lines_.number));
    for (std::size_t c = 0; c < columns; ++c) table_.columns[c].push_back(value_of(c));
  }

  double value_of(std::size_t column) {
    const std::string_view cell = cells_[column];
    if (is_missing(cell)) return unknown;
    const auto value = number(cell, separator_ != ',');
    if (!value) {
      if (mistakes_.size() < most_mistakes)
        fail("column '" + table_.header[column] + "' = " + shown(cell) +
             ": is no number; allowed a decimal number, or an empty cell for no value");
      return unknown;
    }
    if (std::isnan(*value)) return unknown;
    if (!(std::abs(*value) < over_range_code)) {
      ++table_.over_range;
      return unknown;
    }
    return *value;
  }

  std::string file_;
  Lines lines_;
  CsvTable table_;
  char separator_ = ',';
  std::vector<std::string_view> cells_;
  std::vector<std::string> mistakes_;
};

}  // namespace

CsvTable read_csv(std::string_view text, const std::string& file) {
  return Reader(text, file).read();
}

}  // namespace powbench::host
