#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace powbench {

/// "1 closing", "2 closings": a number with the thing it counts, whose plural ends in s.
inline std::string counted(std::size_t n, std::string_view one) {
  return std::to_string(n) + " " + std::string(one) + (n == 1 ? "" : "s");
}

}  // namespace powbench
