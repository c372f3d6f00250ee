#include "dsp/amplifier.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace powbench::dsp {

namespace {

constexpr double table_step = 1.0 / 64;  // of x

/// h(s) ds in units of D: w = sqrt(2), h = 2 exp(-s) sin(s).
constexpr double longest_response = 14;
constexpr int responses = 1400;

std::vector<QuarterPowers> table_of(int side) {
  const double from = side > 0 ? smoothed_from_touch : smoothed_from_release;
  std::vector<double> weight(responses), at(responses);
  double sum = 0;
  for (int k = 0; k < responses; ++k) {
    const double s = (k + 0.5) * longest_response / responses;
    const auto i = static_cast<std::size_t>(k);
    at[i] = s, weight[i] = std::exp(-s) * std::sin(s);
    sum += weight[i];
  }
  std::vector<QuarterPowers> table;
  for (double x = from; x < smoothed_to + 1.5 * table_step; x += table_step) {
    QuarterPowers g{};
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double inside = side > 0 ? x + 1 - at[i] : x - 1 + at[i];
      if (!(inside > 0)) continue;
      const double root = std::sqrt(std::sqrt(inside));
      double p = weight[i] / sum;
      for (double& v : g) v += p, p *= root;
    }
    table.push_back(g);
  }
  return table;
}

}  // namespace

void smoothed_powers(double x, int side, QuarterPowers& out) {
  static const std::vector<QuarterPowers> touch = table_of(+1), release = table_of(-1);
  const auto& table = side > 0 ? touch : release;
  const double at =
      std::max(0.0, (x - (side > 0 ? smoothed_from_touch : smoothed_from_release)) / table_step);
  const auto k = std::min(static_cast<std::size_t>(at), table.size() - 2);
  const double share = std::min(at - static_cast<double>(k), 1.0);
  for (std::size_t p = 0; p < quarter_powers; ++p)
    out[p] = table[k][p] + share * (table[k + 1][p] - table[k][p]);
}

}  // namespace powbench::dsp
