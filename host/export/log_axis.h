#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

/// A logarithmic axis of a picture: whole decades, or steps of 1, 2, 5 where the span is short.

namespace powbench::host {

struct LogAxis {
  double low = 1e300, high = 0;

  void include(double v) {
    if (!(v > 0) || !std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  void widen(double factor) {
    if (high < low) low = high = 1;
    low /= factor;
    high *= factor;
  }
  double share(double v) const { return std::log(v / low) / std::log(high / low); }
  std::vector<double> ticks() const {
    std::vector<double> list;
    const bool dense = high / low < 200;
    for (int d = static_cast<int>(std::floor(std::log10(low))); d <= std::log10(high); ++d)
      for (const double m : {1.0, 2.0, 5.0}) {
        const double v = m * std::pow(10.0, d);
        if ((m == 1 || dense) && v >= low && v <= high) list.push_back(v);
      }
    return list;
  }
};

}  // namespace powbench::host
