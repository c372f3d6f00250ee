#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace powbench::host {

/// The user's input cannot be used. Carries ALL mistakes found, one line each:
/// `file:line: [section] key = value: what is wrong; allowed lo..hi unit; did you mean 'nearest key'?`
/// The command line prints them and ends with Exit::bad_input.
class BadInput : public std::runtime_error {
 public:
  explicit BadInput(std::vector<std::string> errors)
      : std::runtime_error(join(errors)), errors_(std::move(errors)) {}

  /// One sentence each, in the order of the file's lines.
  const std::vector<std::string>& errors() const { return errors_; }

 private:
  static std::string join(const std::vector<std::string>& lines) {
    std::string all;
    for (const auto& line : lines) all += (all.empty() ? "" : "\n") + line;
    return all;
  }
  std::vector<std::string> errors_;
};

}  // namespace powbench::host
