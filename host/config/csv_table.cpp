#include "host/config/csv_table.h"

#include <cmath>
#include <limits>

#include "host/config/bad_input.h"
#include "host/config/cells.h"

namespace powbench::host {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t most_mistakes = 10;

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : file_(file), lines_(plain_text(text, file)) {}

  CsvTable read() {
    read_header();
    while (mistakes_.size() < most_mistakes && lines_.next())
      if (!says_nothing(lines_.text)) read_row();
    if (!mistakes_.empty()) throw BadInput(mistakes_);
    return std::move(table_);
  }

 private:
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
    if (!split_cells(line, separator_, cells_))
      stop("a quote is not closed; allowed cells in pairs of quotes");
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
    if (!split_cells(lines_.text, separator_, cells_))
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
    const auto value = cell_number(cell, separator_ != ',');
    if (!value) {
      if (mistakes_.size() < most_mistakes)
        fail("column '" + table_.header[column] + "' = " + shown_cell(cell) +
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
