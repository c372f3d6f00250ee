#include "host/import/scope_header.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "host/config/cells.h"

namespace powbench::host {
namespace {

struct Word {
  std::string_view text, unit;
  double factor;
};
/// As written, but for the case of whole words.
constexpr std::array words{
    Word{"s", "s", 1},   Word{"ms", "ms", 1}, Word{"us", "us", 1},   Word{"ns", "s", 1e-9},
    Word{"V", "V", 1},   Word{"mV", "mV", 1}, Word{"uV", "V", 1e-6}, Word{"kV", "V", 1e3},
    Word{"A", "A", 1},   Word{"mA", "mA", 1}, Word{"uA", "A", 1e-6}, Word{"kA", "A", 1e3},
    Word{"N", "N", 1},   Word{"mN", "mN", 1}, Word{"kN", "N", 1e3},  Word{"m", "m", 1},
    Word{"mm", "mm", 1}, Word{"um", "um", 1},
};
constexpr std::array spelled{
    Word{"second", "s", 1}, Word{"seconds", "s", 1}, Word{"sec", "s", 1},    Word{"volt", "V", 1},
    Word{"volts", "V", 1},  Word{"voltage", "V", 1}, Word{"amp", "A", 1},    Word{"amps", "A", 1},
    Word{"ampere", "A", 1}, Word{"amperes", "A", 1}, Word{"newton", "N", 1}, Word{"newtons", "N", 1},
    Word{"metre", "m", 1},  Word{"meter", "m", 1},   Word{"v", "V", 1},      Word{"a", "A", 1},
};

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// Without parentheses or brackets around it, the micro sign as `u`.
std::string bare(std::string_view text) {
  text = trimmed_cell(text);
  if (text.size() > 2 &&
      ((text.front() == '(' && text.back() == ')') || (text.front() == '[' && text.back() == ']')))
    text = trimmed_cell(text.substr(1, text.size() - 2));
  for (const std::string_view sign : {"\xC2\xB5", "\xCE\xBC", "\xB5"})
    if (text.starts_with(sign)) return "u" + std::string(text.substr(sign.size()));
  return std::string(text);
}

const Word* find_word(const std::string& text) {
  const auto in = [](const auto& list, const std::string& t) -> const Word* {
    const auto at = std::find_if(list.begin(), list.end(), [&](const Word& w) { return w.text == t; });
    return at == list.end() ? nullptr : &*at;
  };
  if (const Word* w = in(words, text)) return w;
  if (text == "S") return &words[0];  // the horizontal unit of some instruments
  return in(spelled, lower(text));
}

/// Where a unit begins behind a name, and what stands between: npos: nowhere.
std::size_t unit_at(std::string_view cell, std::size_t& length_of_sign) {
  for (const auto& [open, close] : {std::pair{'(', ')'}, {'[', ']'}}) {
    const std::size_t at = cell.rfind(open);
    length_of_sign = 0;
    if (at != std::string_view::npos && cell.back() == close) return at;
  }
  length_of_sign = 4;
  if (const std::size_t at = cell.rfind(" in "); at != std::string_view::npos) return at;
  length_of_sign = 1;
  const std::size_t at = cell.rfind('/');
  return at != std::string_view::npos && find_word(bare(cell.substr(at + 1))) ? at : std::string_view::npos;
}

}  // namespace

ScopeUnit scope_unit(std::string_view text) {
  const std::string unit = bare(text);
  if (const Word* w = find_word(unit)) return {std::string(w->unit), w->factor};
  if (lower(unit) == "value" || lower(unit) == "ampl") return {};
  return {unit, 1.0};
}

bool is_unit_word(std::string_view cell) {
  const std::string word = bare(cell);
  return find_word(word) != nullptr || lower(word) == "sequence" || lower(word) == "value";
}

ScopeColumn scope_column(std::string_view cell, bool unit_behind) {
  cell = trimmed_cell(cell);
  if (cell.starts_with("in ")) return {"time", std::string(trimmed_cell(cell.substr(3)))};
  std::size_t sign = 0;
  const std::size_t at = cell.empty() ? std::string_view::npos : unit_at(cell, sign);
  if (at != std::string_view::npos && at > 0)
    return {std::string(trimmed_cell(cell.substr(0, at))), std::string(trimmed_cell(cell.substr(at + sign)))};
  if (unit_behind && cell.size() > 1 && (cell.back() == 'V' || cell.back() == 'A'))
    return {std::string(cell.substr(0, cell.size() - 1)), std::string(1, cell.back())};
  return {std::string(cell), ""};
}

bool is_scope_name(std::string_view cell) {
  cell = trimmed_cell(cell);
  if (cell.starts_with("in ") || lower(cell).starts_with("tinc")) return true;
  return !cell.empty() && !scope_column(cell, false).unit.empty();
}

bool is_time_name(std::string_view name) {
  static constexpr std::array known{"time",    "t",      "x",         "x-axis", "second",
                                    "seconds", "source", "timestamp", "zeit"};
  const std::string word = lower(name);
  return std::any_of(known.begin(), known.end(), [&](const char* k) { return word == k; }) ||
         word.starts_with("time");
}

}  // namespace powbench::host
