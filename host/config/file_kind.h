#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/config/key_line.h"
#include "host/config/unit.h"

/// A kind of configuration file, declared once: every key with its unit (in the name), range, meaning and target.
/// Reading, error messages, the commented template and the resolved text all follow from the declaration.
/// Defaults are the values the targets hold when the kind is declared.

namespace powbench::host {

/// One of a few words.
struct Choice {
  std::vector<std::string> words;
  std::function<std::size_t()> get;
  std::function<void(std::size_t)> set;
};

/// A list of numbers, or { start, stop, step } for an even one (stop included when a step falls on it).
struct Sweep {
  std::vector<double>* values;
};

/// A list of a fixed number of numbers, each with its own place.
struct Numbers {
  std::vector<double*> places;
};

/// A list of texts; `check` says what is wrong with one, "" when nothing is.
struct Texts {
  std::vector<std::string>* values;
  std::function<std::string(const std::string&)> check;
};

/// A number reached through functions, in SI.
struct Accessor {
  std::function<double()> get;
  std::function<void(double)> set;
  bool whole = false;
};

using Target =
    std::variant<double*, int*, std::uint64_t*, bool*, std::string*, Choice, Sweep, Numbers, Texts, Accessor>;

enum class Need {
  defaulted,  ///< may be left out; the default holds
  required,   ///< must be given
  optional,   ///< may be left out; then there is none (the target stays NaN)
};

/// Closed interval in the unit of the key. NaN and infinities are outside every range.
struct AllowedRange {
  double low = -std::numeric_limits<double>::max();
  double high = std::numeric_limits<double>::max();
};

struct Field {
  std::string section;  ///< "" = top of the file
  std::string key;
  Target target;
  AllowedRange range;
  std::string meaning;
  Need need = Need::defaulted;
  std::string allowed;  ///< "lo..hi unit" or the words; for messages and the template

  const Unit& unit() const { return unit_of_key(key); }
};

struct Section {
  std::string name;
  std::string meaning;
};

class FileKind {
 public:
  /// `name` as in "plan"; `meaning`: what the file is for, one line.
  FileKind(std::string name, std::string meaning) : name_(std::move(name)), meaning_(std::move(meaning)) {}

  /// Fields declared from here on belong to this section.
  void section(std::string name, std::string meaning);

  Field& number(std::string key, double& target, AllowedRange, std::string meaning, Need = Need::defaulted);
  Field& number(std::string key, Accessor, AllowedRange, std::string meaning);
  Field& numbers(std::string key, std::vector<double*> places, AllowedRange, std::string meaning);
  Field& sweep(std::string key, std::vector<double>& target, AllowedRange, std::string meaning, Need);
  Field& integer(std::string key, int& target, AllowedRange, std::string meaning, Need = Need::defaulted);
  Field& seed(std::string key, std::uint64_t& target, std::string meaning);
  Field& yes_no(std::string key, bool& target, std::string meaning);
  Field& text(std::string key, std::string& target, std::string meaning);
  Field& texts(std::string key, Texts, std::string meaning);
  template <class Enum>
  Field& choice(std::string key, Enum& target, std::vector<std::string> words, std::string meaning) {
    return words_field(std::move(key),
                       Choice{std::move(words), [&target] { return static_cast<std::size_t>(target); },
                              [&target](std::size_t i) { target = static_cast<Enum>(i); }},
                       std::move(meaning));
  }

  const std::string& name() const { return name_; }
  const std::vector<Section>& sections() const { return sections_; }
  const std::vector<Field>& fields() const { return fields_; }
  std::vector<Field>& fields() { return fields_; }
  const Field* find(std::string_view section, std::string_view key) const;

  /// A file of this kind for people: every key, its meaning and range, defaults commented out, required keys filled in.
  std::string template_text() const;

  /// Every key with the targets' values, in the order of declaration.
  std::vector<KeyLine> lines() const;

  /// The targets' values as a file: every key once, in the order of declaration. Equal values give equal bytes.
  std::string resolved_text() const;

 private:
  Field& add(std::string key, Target, AllowedRange, std::string meaning, Need);
  Field& words_field(std::string key, Choice, std::string meaning);

  std::string name_, meaning_;
  std::vector<Section> sections_{{"", ""}};
  std::vector<Field> fields_;
};

/// The value of a field as it would stand in a file; "" for an optional one that is not set and for an empty text.
std::string value_text(const Field&);

/// `text` as a TOML basic string.
std::string quoted(std::string_view text);

}  // namespace powbench::host
