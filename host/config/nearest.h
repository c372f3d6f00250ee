#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace powbench::host {

/// Number of single-letter slips (missing, extra, wrong, two swapped) between two words.
int slips(std::string_view a, std::string_view b);

/// The candidate that `word` most likely meant, or "" when none is near: few slips for the word's length, or the same
/// stem with another unit suffix (`gap`, `gap_m` -> `gap_mm`).
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace powbench::host
