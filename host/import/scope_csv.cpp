#include "host/import/scope_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

#include "core/channels.h"
#include "host/config/bad_input.h"
#include "host/config/cells.h"
#include "host/import/scope_header.h"

namespace powbench::host {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t longest_preamble = 400;  // lines
constexpr std::size_t most_columns = 64;
constexpr std::size_t most_mistakes = 10;
constexpr double least_share = 0.98;  // of the samples that the preamble states

using Cells = std::vector<std::string_view>;

Cells cells_of(std::string_view line, char separator) {
  Cells cells;
  if (!split_cells(line, separator, cells)) cells.clear();
  return cells;
}

Cells without_empty_end(Cells cells) {
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

/// How many numbers a line holds; 0 where it holds anything else.
std::size_t numbers_in(std::string_view line, char separator) {
  const Cells cells = without_empty_end(cells_of(line, separator));
  if (cells.empty() || is_missing(cells[0])) return 0;
  for (const auto cell : cells)
    if (!is_missing(cell) && !cell_number(cell, separator != ',')) return 0;
  return cells.size();
}

struct Body {
  char separator = ',';
  std::size_t first = 0, cells = 0;  ///< index into the lines looked at; 0 cells: none found
};

/// The first three lines in a row with equally many numbers.
Body find_body(const std::vector<std::string_view>& lines) {
  Body best;
  for (const char separator : {';', '\t', ','}) {
    std::size_t run = 0, before = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::size_t n = numbers_in(lines[i], separator);
      run = n > 0 && n == before ? run + 1 : (n > 0 ? 1 : 0);
      before = n;
      if (run < 3) continue;
      if (n > best.cells && (separator == ',' || n > 1)) best = {separator, i - 2, n};
      break;
    }
  }
  return best;
}

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : file_(file), rest_(plain_text(text, file)) {}

  CsvTable read() {
    Lines look(rest_);
    while (head_.size() < longest_preamble && look.next())
      if (!says_nothing(look.text)) head_.push_back(look.text), number_.push_back(look.number);
    if (beside()) return take_beside();
    body_ = find_body(head_);
    if (body_.cells == 0)
      refuse_preamble(number_.empty() ? 1 : number_.back(),
                      "no three lines in a row hold equally many numbers");
    if (body_.cells > most_columns)
      throw BadInput({fmt::format("{}:{}: {} columns; allowed 1..{}", file_, number_[body_.first],
                                  body_.cells, most_columns)});
    read_settings();
    name_columns();
    read_rows();
    check_count();
    make_clock();
    return std::move(table_);
  }

 private:
  [[noreturn]] void refuse_preamble(int last, const std::string& why) const {
    throw BadInput(
        {fmt::format("{}:1-{}: the preamble is not understood: {}; allowed lines of settings, a line that "
                     "names the columns (such as "
                     "`TIME,CH1` or `Time(s),CH1(V)`), then rows of numbers: delete what stands above the "
                     "numbers and write "
                     "`time [s],ch1 [V]` there",
                     file_, std::max(last, 1), why)});
  }

  int last_line_of_preamble() const { return body_.first == 0 ? number_[0] : number_[body_.first - 1]; }

  void keep(const Cells& cells) {
    if (cells.empty() || cells[0].empty()) return;
    std::string key = lower(cells[0]);
    while (!key.empty() && (key.back() == ':' || key.back() == ' ')) key.pop_back();
    std::vector<std::string> values;
    for (std::size_t i = 1; i < cells.size(); ++i) values.emplace_back(cells[i]);
    if (!values.empty()) settings_.emplace(key, values);
    // `Segments,1,SegmentSize,1002` holds two settings
    for (std::size_t i = 2; i + 1 < cells.size(); i += 2)
      if (lower(cells[i]) == "segmentsize")
        settings_.emplace("segmentsize", std::vector{std::string(cells[i + 1])});
  }

  void read_settings() {
    for (std::size_t i = 0; i < body_.first; ++i) {
      Cells cells = cells_of(head_[i], body_.separator);
      if (cells.size() == 1) cells = cells_of(head_[i], ',');
      if (cells.size() == 1 && cells[0].find(':') != std::string_view::npos) cells = cells_of(head_[i], ':');
      keep(without_empty_end(cells));
    }
    const double segments = setting({"segments"});
    if (segments > 1)
      throw BadInput({fmt::format("{}: {:g} segments; allowed one: export each segment as a file of its own",
                                  file_, segments)});
  }

  /// The first of these settings that is a number; NaN: none.
  double setting(std::initializer_list<const char*> keys) const {
    for (const char* key : keys) {
      const auto at = settings_.find(key);
      if (at == settings_.end()) continue;
      const auto value = cell_number(at->second[0], body_.separator != ',');
      if (value) return *value;
    }
    return unknown;
  }

  std::string stated_unit(std::size_t column) const {
    for (const char* key : {"vertical units", "yunits", "y units", "vunit"}) {
      const auto at = settings_.find(key);
      if (at == settings_.end()) continue;
      const auto& values = at->second;
      const std::size_t i = values.size() > 1 && column >= 1 ? column - 1 : 0;
      if (i >= values.size()) continue;
      const std::size_t colon = values[i].find(':');  // `CH1:V`
      return colon == std::string::npos ? values[i] : values[i].substr(colon + 1);
    }
    return "";
  }

  void name_columns() {
    const std::size_t n = body_.cells;
    if (body_.first == 0) refuse_preamble(number_[0], "no line stands above the numbers");
    Cells last = without_empty_end(cells_of(head_[body_.first - 1], body_.separator));
    Cells units, names = last;
    if (last.size() >= n &&
        std::all_of(last.begin(), last.begin() + static_cast<std::ptrdiff_t>(n), is_unit_word)) {
      units = last;
      names =
          body_.first < 2 ? Cells{} : without_empty_end(cells_of(head_[body_.first - 2], body_.separator));
    }
    read_clock_cells(names, n);
    read_clock_cells(units, n);
    if (names.size() == n + 2 && lower(names[n]) == "start" && units.size() == n + 2) {
      first_ = cell_number(units[n], body_.separator != ',').value_or(unknown);
      step_ = cell_number(units[n + 1], body_.separator != ',').value_or(unknown);
    }
    const bool bare = names.size() <= 1 && n >= 1 && (names.empty() || lower(names[0]).starts_with("data"));
    if (!bare && names.size() < n)
      refuse_preamble(last_line_of_preamble(), fmt::format("line {} has {} names for {} columns",
                                                           last_line_of_preamble(), names.size(), n));
    for (std::size_t i = 0; i < n; ++i) {
      ScopeColumn c =
          bare ? ScopeColumn{i == 0 && n > 1 ? "time" : fmt::format("ch{}", std::max<std::size_t>(i, 1)), ""}
               : scope_column(names[i], !std::isnan(step_));
      if (c.name.empty() || (units.empty() && cell_number(c.name, false)))
        refuse_preamble(last_line_of_preamble(), "the name of column " + std::to_string(i + 1) + " is " +
                                                     (c.name.empty() ? "empty" : "a number"));
      if (c.unit.empty() && i < units.size()) c.unit = std::string(units[i]);
      if (c.unit.empty() && !(i == 0 && is_time_name(c.name))) c.unit = stated_unit(i);
      columns_.push_back(c);
    }
    sequence_ = lower(columns_[0].unit) == "sequence";
    timed_ = sequence_ || is_time_name(columns_[0].name) || scope_unit(columns_[0].unit).unit == "s";
    if (!timed_) clock_from_settings();
    table_.header_line = last_line_of_preamble();
    table_.notes.push_back(fmt::format("preamble of {} lines read over", last_line_of_preamble()));
  }

  /// `t0 = -0.5`, `tInc = 1e-6` behind the names.
  void read_clock_cells(Cells& cells, std::size_t n) {
    while (cells.size() > n) {
      const std::string_view cell = cells.back();
      const std::size_t equals = cell.find('=');
      if (equals == std::string_view::npos) return;
      const auto value = cell_number(trimmed_cell(cell.substr(equals + 1)), body_.separator != ',');
      const std::string key = lower(trimmed_cell(cell.substr(0, equals)));
      if (key == "t0") first_ = value.value_or(unknown);
      if (key == "tinc") step_ = value.value_or(unknown);
      cells.pop_back();
    }
  }

  void clock_from_settings() {
    if (std::isnan(step_))
      step_ =
          setting({"sample interval", "xinc", "x increment", "increment", "hresolution", "delta(second)"});
    if (std::isnan(first_)) first_ = setting({"xorg", "x origin", "start", "t0", "hoffset"});
    if (std::isnan(first_)) first_ = 0.0;
    if (!(step_ > 0))
      refuse_preamble(last_line_of_preamble(), "no column is the time, and no setting its interval");
  }

  void read_rows() {
    Lines lines(rest_);
    while (lines.number < number_[body_.first] - 1) lines.next();
    const std::size_t n = body_.cells;
    table_.columns.resize(n);
    Cells cells;
    std::vector<std::string> mistakes;
    while (mistakes.size() < most_mistakes && lines.next()) {
      if (says_nothing(lines.text)) continue;
      const auto fail = [&](const std::string& what) {
        mistakes.push_back(fmt::format("{}:{}: {}", file_, lines.number, what));
      };
      if (table_.rows() >= most_rows) {
        fail(fmt::format("more than {} samples; allowed up to that: cut the file", most_rows));
        break;
      }
      if (!split_cells(lines.text, body_.separator, cells)) {
        fail("a quote is not closed; allowed cells in pairs of quotes");
        continue;
      }
      while (cells.size() > n && cells.back().empty()) cells.pop_back();
      if (cells.size() != n) {
        fail(fmt::format("the line has {} cells; allowed {}, as in the rows before", cells.size(), n));
        continue;
      }
      table_.line.push_back(static_cast<std::uint32_t>(lines.number));
      for (std::size_t c = 0; c < n; ++c) {
        const auto value = is_missing(cells[c]) ? unknown : cell_number(cells[c], body_.separator != ',');
        if (!value)
          fail(fmt::format(
              "column '{}' = {}: is no number; allowed a decimal number, or an empty cell for no value",
              columns_[c].name, shown_cell(cells[c])));
        table_.columns[c].push_back(usable(value.value_or(unknown)));
      }
    }
    if (!mistakes.empty()) throw BadInput(mistakes);
  }

  double usable(double v) {
    if (std::isnan(v) || std::abs(v) < over_range_code) return v;
    ++table_.over_range;
    return unknown;
  }

  void check_count() {
    const auto rows = static_cast<double>(table_.rows());
    const double stated = setting({"record length", "points", "segmentsize"});
    const auto gating = settings_.find("gating");
    const bool part = gating != settings_.end() && gating->second[0] != "0.0% to 100.0%";
    if (std::isnan(stated) || stated == rows || part) return;
    if (rows < least_share * stated)
      throw BadInput({fmt::format("{}: the preamble states {:g} samples, the file has {:g}: it is cut", file_,
                                  stated, rows)});
    table_.notes.push_back(fmt::format("the preamble states {:g} samples, the file has {:g}", stated, rows));
  }

  /// Units as those of read_header; the time in front.
  void make_clock() {
    std::vector<std::vector<double>> columns;
    const auto add = [&](const std::string& name, const std::string& unit, std::vector<double> values) {
      table_.header.push_back(name + " [" + unit + "]");
      columns.push_back(std::move(values));
    };
    if (!timed_ || sequence_) {
      if (sequence_ && !(step_ > 0 && std::isfinite(first_)))
        refuse_preamble(last_line_of_preamble(),
                        "the first column is a count, and no Start and Increment give its time");
      std::vector<double> time(table_.rows());
      for (std::size_t i = 0; i < time.size(); ++i)
        time[i] = first_ + step_ * (sequence_ ? table_.columns[0][i] : static_cast<double>(i));
      add("time", "s", std::move(time));
    }
    for (std::size_t c = 0; c < body_.cells; ++c) {
      if (c == 0 && sequence_) continue;
      const bool time = c == 0 && timed_;
      ScopeUnit u = scope_unit(columns_[c].unit.empty() && time ? "s" : columns_[c].unit);
      if (u.unit.empty()) {
        table_.notes.push_back(
            fmt::format("column '{}': the file states no unit, taken as V", columns_[c].name));
        u = {"V", 1.0};
      }
      if (u.factor != 1.0)
        for (double& v : table_.columns[c]) v *= u.factor;
      add(time && lower(columns_[c].name) != "time" ? "time" : columns_[c].name, u.unit,
          std::move(table_.columns[c]));
    }
    table_.columns = std::move(columns);
  }

  /// Tektronix TDS: the settings stand in the first two cells of the lines, the numbers in the fourth and fifth.
  bool beside() const {
    if (head_.size() < 3) return false;
    const Cells cells = cells_of(head_[0], ',');
    return cells.size() >= 5 && lower(cells[0]) == "record length" && cell_number(cells[3], false) &&
           cell_number(cells[4], false);
  }

  CsvTable take_beside() {
    Lines lines(rest_);
    table_.columns.resize(2);
    while (lines.next()) {
      if (says_nothing(lines.text)) continue;
      const Cells cells = cells_of(lines.text, ',');
      keep(without_empty_end({cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(
                                                                 std::min<std::size_t>(cells.size(), 2))}));
      if (table_.rows() >= most_rows)
        throw BadInput({fmt::format("{}: more than {} samples", file_, most_rows)});
      const auto number = [&](std::size_t c) {
        return cells.size() > c ? cell_number(cells[c], false) : std::nullopt;
      };
      const auto x = number(3), y = number(4);
      if (!x || !y)
        throw BadInput({fmt::format(
            "{}:{}: the fourth and fifth cell are no numbers; allowed time and value there, as in the "
            "rows before",
            file_, lines.number)});
      table_.line.push_back(static_cast<std::uint32_t>(lines.number));
      table_.columns[0].push_back(usable(*x));
      table_.columns[1].push_back(usable(*y));
    }
    const auto source = settings_.find("source");
    columns_ = {{"time", "s"}, {source == settings_.end() ? "ch1" : source->second[0], stated_unit(1)}};
    timed_ = true;
    body_ = {',', 0, 2};
    check_count();
    make_clock();
    return std::move(table_);
  }

  const std::string& file_;
  std::string_view rest_;
  std::vector<std::string_view> head_;
  std::vector<int> number_;
  Body body_;
  std::map<std::string, std::vector<std::string>> settings_;
  std::vector<ScopeColumn> columns_;
  bool timed_ = false, sequence_ = false;
  double first_ = unknown, step_ = unknown;
  CsvTable table_;
};

bool known_beginning(std::string_view cell) {
  const std::string word = lower(cell);
  for (const char* begin : {"record length", "model", "lecroy", "x-axis", "revision", "sequence"})
    if (word.starts_with(begin)) return true;
  return false;
}

}  // namespace

bool is_scope_csv(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::string_view> lines;
  Lines look(text);
  while (lines.size() < longest_preamble && look.next())
    if (!says_nothing(look.text)) lines.push_back(look.text);
  if (lines.empty() || lines[0].find('[') != std::string_view::npos) return false;
  const auto has = [&](char c) { return lines[0].find(c) != std::string_view::npos; };
  const char separator = has(';') ? ';' : has('\t') ? '\t' : ',';
  const Cells names = without_empty_end(cells_of(lines[0], separator));
  if (names.empty()) return false;
  for (const auto& name : names)
    for (const ChannelInfo& c : channel_table)
      if (lower(name) == c.name) return false;
  for (const auto& name : names)
    if (is_scope_name(name)) return find_body(lines).cells > 0 || known_beginning(names[0]);
  if (numbers_in(lines[0], separator) > 0) return false;
  if (lines.size() > 1 && numbers_in(lines[1], separator) == names.size()) return false;
  return known_beginning(names[0]) || find_body(lines).cells > 0;
}

CsvTable read_scope_csv(std::string_view text, const std::string& file) {
  return Reader(text, file).read();
}

}  // namespace powbench::host
