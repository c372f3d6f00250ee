#include "host/config/nearest.h"

#include <algorithm>
#include <cctype>
#include <limits>

#include "host/config/unit.h"

namespace powbench::host {
namespace {

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// The key without its unit.
std::string_view stem(std::string_view key) {
  const auto& unit = unit_of_key(key);
  return unit.suffix.empty() || unit.suffix.size() + 1 >= key.size()
             ? key
             : key.substr(0, key.size() - unit.suffix.size() - 1);
}

}  // namespace

int slips(std::string_view a, std::string_view b) {
  const std::size_t columns = b.size() + 1;
  std::vector<int> before(columns), last(columns), row(columns);
  for (std::size_t j = 0; j < columns; ++j) last[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int wrong = last[j - 1] + (a[i - 1] != b[j - 1]);
      row[j] = std::min({wrong, last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string asked = lower(word);
  std::string best;
  int fewest = std::numeric_limits<int>::max();
  for (const auto& candidate : candidates) {
    const std::string offered = lower(candidate);
    int distance = slips(asked, offered);
    const int limit = std::max(2, static_cast<int>(asked.size()) / 3);
    const bool same_stem = asked == stem(offered) || stem(asked) == stem(offered);
    if (same_stem) distance = std::min(distance, 1);
    if (distance > limit || distance >= static_cast<int>(asked.size()) || distance >= fewest) continue;
    fewest = distance;
    best = candidate;
  }
  return best;
}

}  // namespace powbench::host
