#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/architecture/source_rules.h"

/// What no user can reach is not in the product. Two checks on the text of the sources, the tests and benchmarks left
/// out. Both look at names only, so a name that occurs twice counts as used when either is: they miss some, and what
/// they report is unreachable.

namespace powbench::architecture {

/// A source with comments and the contents of literals blanked, line breaks kept.
std::string code_of(const std::string& text);

/// The folders whose code a user runs.
bool in_product(std::string_view path);

/// Something no program reaches: the path of a file or the name of a function, and where it is.
struct Unreached {
  std::string name, where;
};

/// Files that no program needs. A program is a source with `int main(`, all of firmware/port and python, and the
/// interfaces fmu/fmi2 and fmi3. A file needs what it includes; a header needs the sources of its folder that define
/// what it declares.
std::vector<Unreached> files_not_reached(const std::vector<Source>&);

/// Functions that a header declares and no product source calls: the name occurs nowhere else than in declarations and
/// definitions.
std::vector<Unreached> functions_not_reached(const std::vector<Source>&);

/// One line per place outside its file where a rule of said_once() is written a second time.
std::vector<std::string> check_said_once(const std::vector<Source>&);

/// One line per difference between what was found and the names that are known and allowed: a new one, or a known one
/// that is no longer there. `outside`: names that need no caller.
std::vector<std::string> check_reached(const std::vector<Unreached>& found,
                                       const std::vector<std::string_view>& known,
                                       const std::vector<std::string_view>& outside = {});

}  // namespace powbench::architecture
