// The one file that knows the TOML library.

namespace powbench::host {
/// The parser came to a place it believes impossible; some broken files lead it there.
struct ParserLost {};
[[noreturn]] inline void parser_lost() {
  throw ParserLost{};
}
}  // namespace powbench::host

// so the parser's own conditions are checked in every build, and end the parse instead of the program
#undef NDEBUG
#define TOML_ASSERT(expr) ((expr) ? static_cast<void>(0) : powbench::host::parser_lost())
#include <toml++/toml.h>

#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>

#include "host/config/file_reader.h"
#include "host/config/nearest.h"

namespace powbench::host {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Byte offset of a column that counts code points from 1.
std::size_t byte_of_column(const std::string& line, std::size_t column) {
  std::size_t byte = 0;
  for (std::size_t seen = 1; byte < line.size() && seen < column; ++seen) do
      ++byte;
    while (byte < line.size() && (static_cast<unsigned char>(line[byte]) & 0xC0) == 0x80);
  return byte;
}

std::string written(const std::vector<std::string>& lines, const toml::source_region& where) {
  constexpr std::size_t longest = 60;
  const std::size_t row = where.begin.line;
  if (row == 0 || row > lines.size()) return "";
  const std::string& line = lines[row - 1];
  const std::size_t from = byte_of_column(line, where.begin.column);
  const bool one_line = where.end.line == where.begin.line;
  const std::size_t to = one_line ? byte_of_column(line, where.end.column) : line.size();
  std::string text = line.substr(from, to - from);
  if (!one_line || text.size() > longest) {
    std::size_t keep = std::min(text.size(), longest);
    while (keep > 0 && keep < text.size() && (static_cast<unsigned char>(text[keep]) & 0xC0) == 0x80) --keep;
    text = text.substr(0, keep) + " ...";
  }
  return text;
}

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

std::string wants(const toml::node& node, const std::string& wanted) {
  return "is " + kind_of(node) + ", must be " + wanted;
}

bool inside(double value, const Range& range) {
  return value >= range.low && value <= range.high;
}

/// A number in the key's unit, or nothing and the reason in `wrong`.
std::optional<double> number_in(const toml::node& node, const Range& range, const Unit& unit,
                                std::string& wrong) {
  if (!node.is_number()) {
    wrong = wants(node, unit.text.empty() ? "a number" : "a number in " + std::string(unit.text));
    return {};
  }
  const double value = node.value<double>().value();
  if (inside(value, range)) return value;
  wrong = std::isfinite(value) ? "out of range" : "not finite";
  return {};
}

/// Each of these puts a node's value into its target and returns what is wrong with it, "" when nothing is.
struct Assign {
  const Field& field;
  const toml::node& node;

  std::string operator()(double* place) const {
    std::string wrong;
    if (const auto v = number_in(node, field.range, field.unit(), wrong)) *place = to_si(*v, field.unit());
    return wrong;
  }
  std::string operator()(int* place) const {
    const auto v = node.value_exact<std::int64_t>();
    if (!v) return wants(node, "a whole number");
    if (!inside(static_cast<double>(*v), field.range)) return "out of range";
    *place = static_cast<int>(*v);
    return "";
  }
  std::string operator()(std::uint64_t* place) const {
    const auto v = node.value_exact<std::int64_t>();
    if (!v) return wants(node, "a whole number");
    if (*v < 0 || !inside(static_cast<double>(*v), field.range)) return "out of range";
    *place = static_cast<std::uint64_t>(*v);
    return "";
  }
  std::string operator()(const Accessor& accessor) const {
    if (accessor.whole && !node.is_integer()) return wants(node, "a whole number");
    std::string wrong;
    if (const auto v = number_in(node, field.range, field.unit(), wrong))
      accessor.set(to_si(*v, field.unit()));
    return wrong;
  }
  std::string operator()(bool* place) const {
    const auto v = node.value_exact<bool>();
    if (!v) return wants(node, "true or false");
    *place = *v;
    return "";
  }
  std::string operator()(std::string* place) const {
    const auto v = node.value_exact<std::string>();
    if (!v) return wants(node, "text in quotes");
    if (v->empty()) return "is empty";
    *place = *v;
    return "";
  }
  std::string operator()(const Choice& choice) const {
    const auto v = node.value_exact<std::string>();
    if (!v) return wants(node, "one of the words");
    for (std::size_t i = 0; i < choice.words.size(); ++i)
      if (choice.words[i] == *v) return choice.set(i), "";
    const std::string guess = nearest(*v, choice.words);
    return "no such word" + (guess.empty() ? "" : "; did you mean '" + guess + "'?");
  }
  std::string operator()(const Numbers& numbers) const {
    const std::string wanted = "a list of " + std::to_string(numbers.places.size()) + " numbers";
    const auto* list = node.as_array();
    if (list == nullptr) return wants(node, wanted);
    if (list->size() != numbers.places.size())
      return "has " + std::to_string(list->size()) + " items, must be " + wanted;
    std::vector<double> values;
    if (const auto wrong = items(*list, values); !wrong.empty()) return wrong;
    for (std::size_t i = 0; i < values.size(); ++i) *numbers.places[i] = values[i];
    return "";
  }
  std::string operator()(const Sweep& sweep) const {
    if (const auto* table = node.as_table()) return even(*table, *sweep.values);
    const auto* list = node.as_array();
    if (list == nullptr) return wants(node, "a list of numbers or { start, stop, step }");
    if (list->empty()) return "is an empty list";
    std::vector<double> values;
    if (const auto wrong = items(*list, values); !wrong.empty()) return wrong;
    *sweep.values = std::move(values);
    return "";
  }

 private:
  std::string items(const toml::array& list, std::vector<double>& values) const {
    for (const auto& item : list) {
      std::string wrong;
      const auto v = number_in(item, field.range, field.unit(), wrong);
      if (!v) return "item " + std::to_string(values.size() + 1) + " " + wrong;
      values.push_back(to_si(*v, field.unit()));
    }
    return "";
  }

  std::string even(const toml::table& table, std::vector<double>& values) const {
    constexpr double most = 10'000;
    constexpr std::array<const char*, 3> names{"start", "stop", "step"};
    std::array<double, 3> v{};
    for (const auto& [key, value] : table) {
      const std::string name(key.str());
      if (name == "start" || name == "stop" || name == "step") continue;
      const std::string guess = nearest(name, {"start", "stop", "step"});
      return "unknown key '" + name + "'" + (guess.empty() ? "" : "; did you mean '" + guess + "'?");
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const auto* item = table.get(names[i]);
      if (item == nullptr) return "'" + std::string(names[i]) + "' is missing; wants { start, stop, step }";
      std::string wrong;
      const auto number = number_in(*item, i < 2 ? field.range : Range{}, field.unit(), wrong);
      if (!number) return "'" + std::string(names[i]) + "' " + wrong;
      v[i] = *number;
    }
    const double steps = (v[1] - v[0]) / v[2];
    if (v[2] == 0.0 || steps < 0) return "'step' does not lead from 'start' to 'stop'";
    if (steps >= most) return "gives more than 10000 values";
    values.clear();
    for (int i = 0; i <= static_cast<int>(steps + 1e-9);
         ++i)  // decimal steps: keep 0.3 from becoming 0.30000000000000004
      values.push_back(to_si(std::round((v[0] + i * v[2]) * 1e9) / 1e9, field.unit()));
    return "";
  }
};

}  // namespace

/// One pass over a parsed file.
class TomlWalk {
 public:
  TomlWalk(FileReader& reader, const FileKind& kind) : reader_(reader), kind_(kind) {
    lines_ = lines_of(reader.text_);
    for (const auto& section : kind.sections()) {
      tables_.insert(section.name);
      for (auto dot = section.name.find('.'); dot != std::string::npos; dot = section.name.find('.', dot + 1))
        tables_.insert(section.name.substr(0, dot));  // "limits.t_ct1" makes "limits" a known table, too
    }
  }

  void run() {
    const auto root = parse();
    if (!root) return;
    walk(*root, "");
    for (const auto& field : kind_.fields())
      if (field.need == Need::required && !reader_.places_.contains(full_key(field.section, field.key)))
        if (!broken_) reader_.fail(field.section, field.key, "is missing", field.allowed);
  }

 private:
  /// Parses; a line that is wrong by itself, or gives a key twice, is noted, blanked and the rest is read all the same.
  std::optional<toml::table> parse() {
    auto lines = lines_;
    for (;;) {
      std::string text;
      for (const auto& line : lines) text += line + "\n";
      try {
        return toml::parse(text);
      } catch (const ParserLost&) {
        reader_.add(first_lost(lines),
                    "cannot be understood; allowed TOML: key = value, [section], # comment");
        broken_ = true;
        return {};
      } catch (const toml::parse_error& e) {
        const auto row = static_cast<std::size_t>(e.source().begin.line);
        note(e, static_cast<int>(row));
        if (row == 0 || row > lines.size() || lines[row - 1].empty()) return {};
        if (!twice(e) && !wrong_alone(lines[row - 1])) return {};
        lines[row - 1].clear();
      }
    }
  }

  /// The line, from 1, with which the parser first loses its way.
  static int first_lost(const std::vector<std::string>& lines) {
    std::string text;
    for (std::size_t row = 0; row < lines.size(); ++row) {
      text += lines[row] + "\n";
      try {
        static_cast<void>(toml::parse(text));
      } catch (const ParserLost&) {
        return static_cast<int>(row) + 1;
      } catch (const toml::parse_error&) {
        continue;  // an unfinished list, perhaps
      }
    }
    return static_cast<int>(lines.size());
  }

  static bool twice(const toml::parse_error& e) {
    return std::string_view(e.description()).find("redefine existing") != std::string_view::npos &&
           std::string_view(e.description()).find("table") == std::string_view::npos;
  }

  static bool wrong_alone(const std::string& line) {
    if (line.find('=') == std::string::npos) return false;
    try {
      static_cast<void>(toml::parse(line));
      return false;
    } catch (const toml::parse_error&) {
      return true;
    } catch (const ParserLost&) {
      return true;
    }
  }

  void note(const toml::parse_error& e, int row) {
    if (twice(e)) {
      const std::string& line = lines_[static_cast<std::size_t>(row) - 1];
      const std::size_t from = line.find_first_not_of(" \t");
      const std::string key = line.substr(from, line.find_first_of(" \t=", from) - from);
      reader_.add(row, key + ": given twice; keep one of the two lines");
      return;
    }
    broken_ = true;
    std::string what(e.description());
    if (const auto colon = what.find(": ");
        what.starts_with("Error while parsing") && colon != std::string::npos)
      what = what.substr(colon + 2);
    reader_.add(std::max(row, 1), "not TOML: " + what);
  }

  void walk(const toml::table& table, const std::string& path) {
    reader_.places_[full_key(path, "")] = {static_cast<int>(table.source().begin.line), "", false};
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const std::string full = full_key(path, name);
      FileReader::Place place{static_cast<int>(key.source().begin.line), written(lines_, node.source()),
                              false};
      if (const Field* field = kind_.find(path, name)) {
        const std::string wrong = std::visit(Assign{*field, node}, field->target);
        reader_.places_[full] = place;
        if (!wrong.empty()) reader_.fail(path, name, wrong, field->allowed);
      } else if (tables_.contains(full)) {
        if (const auto* inner = node.as_table()) {
          walk(*inner, full);
        } else {
          reader_.add(place.line, full + ": is a section: write [" + full + "] and its keys below");
        }
      } else if (node.is_table() || node.is_array_of_tables()) {
        const std::string guess = nearest(full, sections());
        reader_.add(place.line, "[" + full + "]: unknown section" +
                                    (guess.empty() ? known(sections()) : "; did you mean '" + guess + "'?"));
      } else {
        reader_.add(path, name, place, unknown(path, name), "");
      }
    }
  }

  /// What to say of a key that this section does not have.
  std::string unknown(const std::string& path, const std::string& name) const {
    std::vector<std::string> here, everywhere;
    for (const auto& field : kind_.fields()) (field.section == path ? here : everywhere).push_back(field.key);
    if (const auto guess = nearest(name, here); !guess.empty()) return unknown_guess(guess);
    for (const auto& field : kind_.fields())
      if (field.key == name) return "unknown key here; did you mean '" + full_key(field.section, name) + "'?";
    const auto guess = nearest(name, everywhere);
    for (const auto& field : kind_.fields())
      if (!guess.empty() && field.key == guess) return unknown_guess(full_key(field.section, guess));
    return "unknown key" + known(here);
  }

  static std::string unknown_guess(const std::string& guess) {
    return "unknown key; did you mean '" + guess + "'?";
  }

  static std::string known(const std::vector<std::string>& words) {
    std::string text;
    for (const auto& word : words) text += (text.empty() ? "; known: " : ", ") + word;
    return text;
  }

  std::vector<std::string> sections() const {
    std::vector<std::string> names;
    for (const auto& section : kind_.sections())
      if (!section.name.empty()) names.push_back(section.name);
    return names;
  }

  FileReader& reader_;
  const FileKind& kind_;
  std::vector<std::string> lines_;
  std::set<std::string> tables_;
  bool broken_ = false;  ///< part of the file could not be read: keys may only seem to be missing
};

void FileReader::read(const FileKind& kind) {
  TomlWalk(*this, kind).run();
}

}  // namespace powbench::host
