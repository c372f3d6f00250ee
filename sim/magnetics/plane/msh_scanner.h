#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// Numbers and words from the two forms of an MSH file, with the place of the first fault. Private to msh.cpp.

namespace powbench::sim {

class MshScanner {
 public:
  explicit MshScanner(std::string_view content) : content_(content) {}

  void set_binary(bool on) { binary_ = on; }
  bool binary() const { return binary_; }

  /// Throws std::invalid_argument "line N: text".
  [[noreturn]] void fail(const std::string& text) const;

  bool at_end();              ///< only white space is left
  std::string_view word();    ///< up to the next white space; always text
  std::string_view line();    ///< the rest of the line, its end consumed; always text
  std::string_view quoted();  ///< between two " on one line; always text
  void expect(std::string_view word);

  /// Passes over everything up to and including the line `word`.
  void skip_past(std::string_view word);

  /// The end of the line after a section's name, where binary data begin.
  void begin_data();

  /// An integer: 4 bytes in binary data. `what` names it in the error.
  int integer(const char* what);
  /// A count or a tag >= 0: 8 bytes in binary data.
  std::int64_t size(const char* what);
  /// A count that what is left of the file can hold, with at least `bytes` characters an item.
  std::int64_t count(const char* what, int bytes);
  /// A finite number: 8 bytes in binary data.
  double real(const char* what);

 private:
  void skip_space();
  template <class T>
  T raw(const char* what);
  std::int64_t text_integer(const char* what, std::int64_t low, std::int64_t high);

  std::string_view content_;
  std::size_t at_ = 0;
  int line_ = 1;
  bool binary_ = false;
};

}  // namespace powbench::sim
