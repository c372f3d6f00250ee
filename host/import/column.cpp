#include "host/import/column.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "host/config/bad_input.h"
#include "host/config/nearest.h"

namespace powbench::host {

namespace {

struct ColumnUnit {
  std::string_view text;
  Kind kind;
  double factor;
};

constexpr std::array column_units{
    ColumnUnit{"s", Kind::seconds, 1.0},   ColumnUnit{"ms", Kind::seconds, 1e-3},
    ColumnUnit{"us", Kind::seconds, 1e-6}, ColumnUnit{"N", Kind::newtons, 1.0},
    ColumnUnit{"mN", Kind::newtons, 1e-3}, ColumnUnit{"V", Kind::volts, 1.0},
    ColumnUnit{"mV", Kind::volts, 1e-3},   ColumnUnit{"m", Kind::metres, 1.0},
    ColumnUnit{"mm", Kind::metres, 1e-3},  ColumnUnit{"um", Kind::metres, 1e-6},
    ColumnUnit{"A", Kind::amperes, 1.0},   ColumnUnit{"mA", Kind::amperes, 1e-3},
};

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && s.front() == ' ') s.remove_prefix(1);
  while (!s.empty() && s.back() == ' ') s.remove_suffix(1);
  return s;
}

/// The micro sign in UTF-8 (two code points) and Latin-1 as `u`.
std::string plain_micro(std::string text) {
  for (const std::string_view sign : {"\xC2\xB5", "\xCE\xBC", "\xB5"})
    if (text.starts_with(sign)) return "u" + text.substr(sign.size());
  return text;
}

std::vector<std::string> names() {
  std::vector<std::string> list{"time"};
  for (const auto& c : channel_table) list.emplace_back(c.name);
  return list;
}

/// What the channel shows without calibration.
Kind kind_of(Channel c) {
  const std::string_view unit = info(c).unit;
  return unit == "N" ? Kind::newtons : unit == "m" ? Kind::metres : unit == "A" ? Kind::amperes : Kind::volts;
}

std::string units_of(Kind kind, bool volts_too) {
  std::string list;
  for (const auto& u : column_units)
    if (u.kind == kind || (volts_too && u.kind == Kind::volts))
      list += (list.empty() ? "" : ", ") + std::string(u.text);
  return list;
}

/// Fills the column, or returns what is wrong with it.
std::string parse(const std::string& cell, Column& column) {
  column.title = cell;
  const std::string label = "column '" + cell + "': ";
  const std::size_t open = cell.find('['), close = cell.rfind(']');
  const std::string name = lower(trimmed(std::string_view(cell).substr(0, open)));
  const auto known = names();
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) {
    const std::string meant = nearest(name, known);
    return label + "is not known; allowed " + known_columns() +
           (meant.empty() ? "; a calibration file with [columns] says what foreign ones are, `powbench "
                            "import --suggest` writes it"
                          : "; did you mean '" + meant + "'?");
  }
  const bool is_time = found == known.begin();
  if (!is_time) column.channel = static_cast<Channel>(found - known.begin() - 1);
  const Kind own = is_time ? Kind::seconds : kind_of(*column.channel);
  const bool volts_too = !is_time && own != Kind::volts;
  const std::string allowed = "; allowed " + units_of(own, volts_too);
  if (open == std::string::npos || close == std::string::npos || close < open)
    return label + "has no unit; write it in brackets, as in `" + name + " [" +
           std::string(is_time ? "s" : info(*column.channel).unit) + "]`" + allowed;
  const std::string unit =
      plain_micro(std::string(trimmed(std::string_view(cell).substr(open + 1, close - open - 1))));
  const auto u = std::find_if(column_units.begin(), column_units.end(), [&](const auto& entry) {
    return entry.text == unit && (entry.kind == own || (volts_too && entry.kind == Kind::volts));
  });
  if (u == column_units.end()) return label + "unit '" + unit + "' does not fit" + allowed;
  column.kind = u->kind;
  column.factor = u->factor;
  column.calibrated = u->kind == own;
  return "";
}

/// `in s`, as some instruments write it: a time column and its unit; "" = another cell.
std::string in_seconds(const std::string& cell) {
  for (const char* unit : {"s", "ms", "us"})
    if (cell == std::string("in ") + unit) return unit;
  return "";
}

/// `name [unit]` apart; no unit where there are no brackets.
std::pair<std::string, std::string> apart(const std::string& given) {
  if (const std::string unit = in_seconds(given); !unit.empty()) return {given, unit};
  std::string cell = given;  // `CH1(V)`, as instruments write it, is `CH1[V]`
  if (cell.ends_with(')') && cell.find('[') == std::string::npos && cell.find('(') != std::string::npos)
    cell[cell.rfind('(')] = '[', cell.back() = ']';
  const std::size_t open = cell.find('['), close = cell.rfind(']');
  std::string name(trimmed(std::string_view(cell).substr(0, open)));
  if (open == std::string::npos || close == std::string::npos || close < open) return {name, ""};
  return {name, std::string(trimmed(std::string_view(cell).substr(open + 1, close - open - 1)))};
}

/// What a foreign cell is called here, with its unit; nothing when no entry names it.
std::optional<std::string> own_title(const std::string& cell, const ForeignColumns& foreign) {
  const auto known = names();
  const auto [name, unit] = apart(cell);
  for (std::size_t i = 0; i < foreign.size(); ++i) {
    if (foreign[i].empty()) continue;
    const auto [wanted, wanted_unit] = apart(foreign[i]);
    if (foreign[i] != cell && wanted != name) continue;
    const std::string& u = wanted_unit.empty() ? unit : wanted_unit;
    return u.empty() ? known[i] : known[i] + " [" + u + "]";
  }
  return std::nullopt;
}

}  // namespace

std::string known_columns() {
  std::string list;
  for (const auto& n : names()) list += (list.empty() ? "" : ", ") + n;
  return list;
}

std::vector<Column> read_header(const std::vector<std::string>& cells, const std::string& file, int line,
                                bool clock, const ForeignColumns& foreign) {
  const bool any_foreign =
      std::any_of(foreign.begin(), foreign.end(), [](const std::string& f) { return !f.empty(); });
  std::vector<Column> columns(cells.size());
  std::array<int, 1 + channel_count> answered{};
  std::vector<std::string> mistakes;
  const auto fail = [&](const std::string& what) {
    mistakes.push_back(file + ":" + std::to_string(line) + ": " + what);
  };
  int times = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    auto own = own_title(cells[i], foreign);
    const bool named = own.has_value();
    if (const std::string unit = in_seconds(cells[i]); !own && !unit.empty()) own = "time [" + unit + "]";
    const auto list = names();
    const bool ours = std::find(list.begin(), list.end(), lower(apart(cells[i]).first)) != list.end();
    if (any_foreign && !own && !ours) {
      columns[i].title = cells[i];
      columns[i].passed_over = true;
      continue;
    }
    std::string wrong = parse(own.value_or(cells[i]), columns[i]);
    if (own) {
      columns[i].title = cells[i];
      ++answered[columns[i].channel ? 1 + index(*columns[i].channel) : 0];
      if (!wrong.empty() && named) wrong = "column '" + cells[i] + "', named in [columns]: " + wrong;
    }
    if (!wrong.empty()) {
      fail(wrong);
      if (lower(cells[i]).starts_with("time")) ++times;
      continue;
    }
    times += !columns[i].channel;
    for (std::size_t j = 0; j < i; ++j)
      if (columns[j].title.size() && !columns[j].passed_over && columns[j].channel == columns[i].channel &&
          columns[i].channel)
        fail("column '" + cells[i] + "': the channel stands here twice; allowed once");
  }
  for (std::size_t i = 0; i < foreign.size(); ++i)
    if (!foreign[i].empty() && answered[i] == 0 && mistakes.empty()) {
      std::string header;
      for (const std::string& cell : cells) header += (header.empty() ? "'" : ", '") + cell + "'";
      std::size_t other = 0;
      while (other < i && (foreign[other].empty() || apart(foreign[other]).first != apart(foreign[i]).first))
        ++other;
      fail("[columns] " + names()[i] + " = \"" + foreign[i] + "\": " +
           (other < i ? "that column is " + names()[other] + " already; allowed once"
                      : "no column has that name; the header has " + header));
    }
  const auto passed = std::count_if(columns.begin(), columns.end(), [](auto& c) { return c.passed_over; });
  if ((times > 1 || (times == 0 && clock)) && mistakes.empty())
    fail("the header has " + std::to_string(times) + " time columns; allowed one, as in `time [s]`" +
         (times == 0
              ? "; [columns] time = \"NAME [s]\" in the calibration file names one that is called otherwise"
              : ""));
  if (cells.size() - static_cast<std::size_t>(times) - static_cast<std::size_t>(passed) < 1 &&
      mistakes.empty())
    fail("the header has no channel; allowed " + known_columns());
  if (!mistakes.empty()) throw BadInput(mistakes);
  return columns;
}

}  // namespace powbench::host
