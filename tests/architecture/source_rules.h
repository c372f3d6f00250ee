#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Checks source text against the rules of tests/architecture/rules.h. Pure functions: the tests feed them
/// the real tree as well as made-up sources that break a rule.

namespace powbench::architecture {

struct Source {
  std::string path;  ///< relative to the top of the project, with forward slashes
  std::string text;
};

struct Include {
  int line = 0;
  bool angled = false;  ///< <header>, not "header"
  std::string target;
};

/// The #include lines of a source, comments left out.
std::vector<Include> includes(const Source&);

/// Each function returns one line per violation, `path:line: what is wrong`; empty = clean.
std::vector<std::string> check_arrows(const std::vector<Source>&);
std::vector<std::string> check_third_party(const std::vector<Source>&);
std::vector<std::string> check_firmware_reach(const std::vector<Source>&);
std::vector<std::string> check_cycles(const std::vector<Source>&);
/// Of the folders of `order` none includes a later one.
std::vector<std::string> check_order(const std::vector<Source>&, const std::vector<std::string_view>& order);
std::vector<std::string> check_text(const std::vector<Source>&);
/// No test sleeps or reads a clock.
std::vector<std::string> check_waiting(const std::vector<Source>&);

}  // namespace powbench::architecture
