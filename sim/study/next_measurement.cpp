#include "sim/study/next_measurement.h"

#include <algorithm>
#include <cmath>

namespace powbench::sim {
namespace {

/// Row by row.
std::vector<double> covariances(std::span<const std::vector<double>> samples, std::size_t width) {
  const auto n = static_cast<double>(samples.size());
  std::vector<double> mean(width), c(width * width);
  for (const auto& s : samples)
    for (std::size_t i = 0; i < width; ++i) mean[i] += s[i] / n;
  for (const auto& s : samples)
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t j = 0; j < width; ++j)
        c[i * width + j] += (s[i] - mean[i]) * (s[j] - mean[j]) / (n - 1);
  return c;
}

}  // namespace

std::vector<Informative> most_informative(std::span<const std::vector<double>> samples,
                                          std::span<const double> u, std::size_t count) {
  const std::size_t width = u.size();
  std::vector<double> c = covariances(samples, width);
  std::vector<bool> chosen(width, false);
  std::vector<Informative> list;
  while (list.size() < std::min(count, width)) {
    Informative best;
    for (std::size_t i = 0; i < width; ++i) {
      if (chosen[i]) continue;
      const double variance = std::max(0.0, c[i * width + i]);
      const double bits = 0.5 * std::log2(1 + variance / (u[i] * u[i]));
      if (best.bits == 0 || bits > best.bits) best = {i, bits, std::sqrt(variance), {}};
    }
    if (!(best.bits > 0)) break;
    const std::size_t k = best.candidate;
    chosen[k] = true;
    std::vector<double> column(width);
    for (std::size_t i = 0; i < width; ++i) column[i] = c[i * width + k];
    const double total = best.spread * best.spread + u[k] * u[k];
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t j = 0; j < width; ++j) c[i * width + j] -= column[i] * column[j] / total;
    for (std::size_t i = 0; i < width; ++i) best.left.push_back(std::max(0.0, c[i * width + i]));
    list.push_back(std::move(best));
  }
  return list;
}

}  // namespace powbench::sim
