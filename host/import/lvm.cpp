#include "host/import/lvm.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view end_of_header = "***End_of_Header***";

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.front())) != 0) s.remove_prefix(1);
  while (!s.empty() && std::isspace(static_cast<unsigned char>(s.back())) != 0) s.remove_suffix(1);
  return s;
}

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t end = line.find(separator);
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

/// LabVIEW's name of a unit -> ours.
std::string unit_of(std::string_view label) {
  static const std::map<std::string_view, std::string_view> known{
      {"Volts", "V"}, {"Newtons", "N"}, {"Amperes", "A"}, {"Amps", "A"}, {"Meters", "m"}, {"Metres", "m"}};
  const auto at = known.find(label);
  if (at != known.end()) return std::string(at->second);
  return label.empty() ? "V" : std::string(label);
}

/// One pass over the lines.
class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  CsvTable read() {
    while (!text_.empty()) take(next_line());
    if (table_.rows() < 2) refuse("has fewer than two rows of numbers");
    return std::move(table_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw BadInput({file_ + ": " + why}); }
  [[noreturn]] void refuse_line(const std::string& why) const {
    throw BadInput({fmt::format("{}:{}: {}", file_, line_, why)});
  }

  std::string_view next_line() {
    const std::size_t end = text_.find('\n');
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    ++line_;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    return line;
  }

  void take(std::string_view line) {
    if (trimmed(line).empty()) return;
    if (line_ == 1) in_header_ = line.starts_with("LabVIEW Measurement");
    if (in_header_) return take_header(line);
    const auto cells = cells_of(line, separator_);
    if (cells[0] == "X_Value") return take_labels(cells);
    if (is_header_key(cells[0])) {
      if (table_.rows() > 0) refuse_line("a second segment begins; export each segment as a file of its own");
      in_header_ = true;
      return take_header(line);
    }
    take_row(cells);
  }

  static bool is_header_key(std::string_view cell) {
    return cell == "Channels" || cell == "Samples" || cell == "X0" || cell == "Delta_X" ||
           cell == "Y_Unit_Label";
  }

  void take_header(std::string_view line) {
    if (line.starts_with(end_of_header)) {
      in_header_ = false;
      return;
    }
    // the separator is named before anything that it separates
    if (line.starts_with("Separator")) {
      const std::string_view name = trimmed(line.substr(9));
      separator_ = name.starts_with("Comma") || name.ends_with("Comma") ? ',' : '\t';
      return;
    }
    const auto cells = cells_of(line, separator_);
    if (cells.size() < 2) return;
    if (cells[0] == "Decimal_Separator") decimal_ = cells[1] == "," ? ',' : '.';
    if (cells[0] == "X_Columns") {
      if (cells[1] == "Multi")
        refuse_line("X_Columns Multi: a time column for each channel; write the file with one, or none");
      x_column_ = cells[1] != "No";
    }
    if (cells[0] == "Y_Unit_Label") units_.assign(cells.begin() + 1, cells.end());
    if (cells[0] == "X0") first_ = value(cells[1]);
    if (cells[0] == "Delta_X") {
      step_ = value(cells[1]);
      if (!(step_ > 0)) refuse_line(fmt::format("Delta_X {}; above 0 s", cells[1]));
    }
    if (cells[0] == "Channels") {
      const double n = value(cells[1]);
      if (!(n >= 1 && n <= 64)) refuse_line(fmt::format("{} channels; allowed 1 to 64", cells[1]));
      channels_ = static_cast<std::size_t>(n);
    }
  }

  void take_labels(const std::vector<std::string_view>& cells) {
    labels_.assign(cells.begin() + 1, cells.end());
    if (!labels_.empty() && labels_.back() == "Comment") labels_.pop_back();
  }

  double value(std::string_view cell) const {
    std::string text(cell);
    if (decimal_ == ',')
      for (char& c : text)
        if (c == ',') c = '.';
    const char* at = text.data() + (text.starts_with('+') ? 1 : 0);
    double number = 0;
    const auto [rest, error] = std::from_chars(at, text.data() + text.size(), number);
    if (error != std::errc() || rest != text.data() + text.size())
      refuse_line(fmt::format("'{}' is no number", cell));
    return number;
  }

  /// The first row of numbers says how many columns there are: what stands behind them in single rows is a comment.
  void begin(std::size_t cells) {
    std::size_t n = cells - (x_column_ ? 1 : 0);
    if (channels_ > 0) n = channels_;
    if (channels_ == 0 && !labels_.empty()) n = labels_.size();
    if (n < 1 || n > 64) refuse_line(fmt::format("{} channels; allowed 1 to 64", n));
    table_.header_line = line_;
    table_.header.emplace_back("time [s]");
    for (std::size_t c = 0; c < n; ++c) {
      const std::string name =
          c < labels_.size() && !labels_[c].empty() ? std::string(labels_[c]) : fmt::format("ch{}", c + 1);
      table_.header.push_back(name + " [" + (c < units_.size() ? unit_of(units_[c]) : "V") + "]");
    }
    table_.columns.resize(n + 1);
  }

  void take_row(const std::vector<std::string_view>& cells) {
    if (table_.columns.empty()) begin(cells.size());
    if (table_.rows() >= most_rows) refuse(fmt::format("has more than {} rows", most_rows));
    const double at = first_ + step_ * static_cast<double>(table_.rows());
    const std::size_t from = x_column_ ? 1 : 0;
    if (!x_column_ && !std::isfinite(at)) refuse_line("no time column and no Delta_X");
    // with "X_Columns No" the first cell of a row may stand empty
    const std::size_t shift =
        !x_column_ && cells.size() > table_.columns.size() - 1 && cells[0].empty() ? 1 : from;
    table_.columns[0].push_back(x_column_ && !cells[0].empty() ? value(cells[0]) : at);
    for (std::size_t c = 1; c < table_.columns.size(); ++c) {
      const std::size_t k = c - 1 + shift;
      const double v = k < cells.size() && !cells[k].empty() ? value(cells[k]) : nothing;
      if (std::isinf(v)) ++table_.over_range;
      table_.columns[c].push_back(std::isfinite(v) ? v : nothing);
    }
    table_.line.push_back(static_cast<std::uint32_t>(line_));
  }

  std::string_view text_;
  const std::string& file_;
  int line_ = 0;
  bool in_header_ = false, x_column_ = true;
  char separator_ = '\t', decimal_ = '.';
  std::size_t channels_ = 0;
  double first_ = 0.0, step_ = nothing;
  std::vector<std::string_view> units_, labels_;
  CsvTable table_;
};

}  // namespace

CsvTable parse_lvm(std::string_view text, const std::string& file) {
  return Reader(text, file).read();
}

bool is_lvm(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".lvm";
}

}  // namespace powbench::host
