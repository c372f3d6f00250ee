#include "dsp/contacts/amplifier.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dsp/signal/wide.h"

namespace powbench::dsp {

namespace {

constexpr double table_step = 1.0 / 64;  // of x

/// h(s) ds in units of D: w = sqrt(2), h = 2 exp(-s) sin(s), in the middle of cells of a table step: the place where
/// a power begins is the edge of one.
constexpr double longest_response = 14, cell = table_step;
constexpr auto responses = static_cast<std::size_t>(longest_response / cell);

POWBENCH_WIDE std::vector<QuarterPowers> table_of(int side) {
  const double from = side > 0 ? smoothed_from_touch : smoothed_from_release;
  // times inside are odd multiples of half a cell: their powers
  std::vector<QuarterPowers> powers(static_cast<std::size_t>((smoothed_to + longest_response + 2) / cell));
  for (std::size_t i = 0; i < powers.size(); ++i) {
    const double root = std::sqrt(std::sqrt((static_cast<double>(i) + 0.5) * cell));
    double p = 1;
    for (double& v : powers[i]) v = p, p *= root;
  }
  std::vector<double> weight(responses);
  double sum = 0;
  for (std::size_t k = 0; k < responses; ++k) {
    const double s = (static_cast<double>(k) + 0.5) * cell;
    weight[k] = std::exp(-s) * std::sin(s);
    sum += weight[k];
  }
  for (double& w : weight) w /= sum;
  const auto nodes = static_cast<std::size_t>((smoothed_to - from) / table_step) + 2;
  std::vector<QuarterPowers> table(nodes, QuarterPowers{});
  for (std::size_t j = 0; j < nodes; ++j) {
    // cells from the force's start to x of the node, and on its other side
    const double x = from + static_cast<double>(j) * table_step;
    const auto start = static_cast<std::ptrdiff_t>(std::lround((side > 0 ? x + 1 : 1 - x) / cell));
    for (std::size_t k = 0; k < responses; ++k) {
      const auto at = static_cast<std::ptrdiff_t>(k);
      const std::ptrdiff_t inside = side > 0 ? start - 1 - at : at - start;
      if (inside < 0) continue;
      const QuarterPowers& p = powers[static_cast<std::size_t>(inside)];
      for (std::size_t q = 0; q < p.size(); ++q) table[j][q] += weight[k] * p[q];
    }
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
