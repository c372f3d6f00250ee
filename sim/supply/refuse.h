#pragma once

#include <cstdio>
#include <stdexcept>

/// Refusals of this folder, all in one form. Private to it.

namespace powbench::sim {

/// Throws std::invalid_argument unless low <= value <= high; NaN is refused.
inline void require_range(const char* key, double value, double low, double high, const char* unit) {
  if (value >= low && value <= high) return;
  char text[160];
  std::snprintf(text, sizeof text, "%s = %.6g, allowed %.6g .. %.6g %s", key, value, low, high, unit);
  throw std::invalid_argument(text);
}

}  // namespace powbench::sim
