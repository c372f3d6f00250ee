#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

/// How often a stated error covers a true one.

namespace bench {

struct Coverage {
  int happened = 0, covered = 0, unknown = 0;
  double worst_ratio = 0, worst_error = 0, worst_stated = 0;
  int worst_scene = -1;
  std::vector<double> ratio;  ///< stated over true
  void add(int scene, double stated, double error) {
    if (std::isnan(error)) return;
    if (std::isnan(stated)) {
      ++unknown;
      return;
    }
    ++happened;
    if (error > 0) ratio.push_back(stated / error);
    if (error <= stated) {
      ++covered;
      return;
    }
    if (!(error / stated > worst_ratio)) return;
    worst_ratio = error / stated;
    worst_error = error;
    worst_stated = stated;
    worst_scene = scene;
  }
  /// How much larger than the error what is stated is, in one of ten scenes, half of them and nine of ten: coverage
  /// alone does not tell a bound from a guess that is far too large.
  double ratio_at(double share) {
    std::sort(ratio.begin(), ratio.end());
    return ratio.empty() ? std::nan("")
                         : ratio[static_cast<std::size_t>(share * static_cast<double>(ratio.size() - 1))];
  }
};

/// Head of the lines of `print_coverage`.
inline void print_coverage_head() {
  std::printf(
      "%-16s %-8s %9s %9s %8s  stated / true: 10 %%   median     90 %%   worst miss: us stated  us true  "
      "scene\n",
      "rung", "quantity", "happened", "covered %", "unknown");
}

/// A line, and the same for a file.
inline nlohmann::ordered_json print_coverage(std::string_view rung, std::string_view quantity, Coverage& t) {
  const double share = t.happened > 0 ? 100.0 * t.covered / t.happened : std::nan("");
  std::printf("%-16s %-8s %9d %9.1f %8d  %19.2f %8.2f %8.2f   %21.3g %8.3g %6d\n", std::string(rung).c_str(),
              std::string(quantity).c_str(), t.happened, share, t.unknown, t.ratio_at(0.1), t.ratio_at(0.5),
              t.ratio_at(0.9), t.worst_stated * 1e6, t.worst_error * 1e6, t.worst_scene);
  return {{"rung", rung},
          {"quantity", quantity},
          {"happened", t.happened},
          {"covered_percent", share},
          {"stated_over_true_10_percent", t.ratio_at(0.1)},
          {"stated_over_true_median", t.ratio_at(0.5)},
          {"stated_over_true_90_percent", t.ratio_at(0.9)},
          {"worst_stated_s", t.worst_stated},
          {"worst_error_s", t.worst_error}};
}

}  // namespace bench
