#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/config/bad_input.h"
#include "host/config/file_kind.h"

namespace powbench::host {

/// Reads one TOML file into the targets of a kind and collects every mistake on the way.
/// Use: read(), then cross-field checks with fail(), then finish().
class FileReader {
 public:
  /// `file` names the text in messages.
  FileReader(std::string file, std::string text) : file_(std::move(file)), text_(std::move(text)) {}

  /// Throws BadInput when the file cannot be read.
  static FileReader open(const std::filesystem::path&);

  /// Fills the targets. Unknown keys, wrong types, values out of range, missing and double keys and what is no TOML
  /// are kept as mistakes; a target with a mistake keeps its default.
  void read(const FileKind&);

  /// Adds a mistake about a key; its line and value are found here. `allowed` may be empty.
  void fail(std::string_view section, std::string_view key, const std::string& what,
            const std::string& allowed = {});

  /// The key stands in the file and was free of mistakes so far.
  bool good(std::string_view section, std::string_view key) const;

  /// The key had a mistake: its target still holds the default, so cross-field checks on it would mislead.
  bool bad(std::string_view section, std::string_view key) const;

  /// Throws BadInput with all mistakes, ordered by line, when there are any.
  void finish() const;

 private:
  friend class TomlWalk;
  struct Place {
    int line = 1;
    std::string value;  ///< as written, shortened
    bool bad = false;
  };
  struct Mistake {
    int line;
    std::string text;
  };
  void add(int line, const std::string& text);
  void add(std::string_view section, std::string_view key, const Place&, const std::string& what,
           const std::string& allowed);

  std::string file_, text_;
  std::map<std::string, Place, std::less<>> places_;  ///< by "section.key"; sections by "section."
  std::vector<Mistake> mistakes_;
};

/// Name of a key with its section, as in `bridges.gap_mm`.
std::string full_key(std::string_view section, std::string_view key);

}  // namespace powbench::host
