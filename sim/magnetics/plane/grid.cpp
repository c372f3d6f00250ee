#include "sim/magnetics/plane/grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace powbench::sim {
namespace {

/// Cell size at x: the least that the stops of one interval ask for.
struct Sizes {
  GridStop left, right;
  double slope, largest;

  double at(double x) const {
    double size = largest;
    if (left.size > 0) size = std::min(size, left.size + slope * (x - left.at));
    if (right.size > 0) size = std::min(size, right.size + slope * (right.at - x));
    return size;
  }
};

/// Places lines inside one interval so that each cell takes an equal share of the integral of dx / size.
void fill(const Sizes& sizes, std::vector<double>& lines) {
  constexpr int samples = 2000;
  const double a = sizes.left.at, b = sizes.right.at;
  std::vector<double> integral(samples + 1, 0.0);
  const double step = (b - a) / samples;
  for (int k = 0; k < samples; ++k)
    integral[static_cast<std::size_t>(k) + 1] =
        integral[static_cast<std::size_t>(k)] + step / sizes.at(a + (k + 0.5) * step);
  const int cells = std::max(1, static_cast<int>(std::lround(integral.back() + 0.3)));
  for (int c = 1; c < cells; ++c) {
    const double wanted = integral.back() * c / cells;
    const auto above = std::upper_bound(integral.begin(), integral.end(), wanted);
    const auto k = static_cast<double>(above - integral.begin()) - 1;
    lines.push_back(a + step * (k + (wanted - *(above - 1)) / (*above - *(above - 1))));
  }
}

}  // namespace

std::vector<double> graded_lines(const std::vector<GridStop>& stops, double growth, double largest) {
  auto known = stops;
  const double slope = std::log(growth);
  // a stop without a size takes what its neighbours leave it
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t k = 1; k < known.size(); ++k) {
      const double offered =
          known[k - 1].size > 0 ? known[k - 1].size + slope * (known[k].at - known[k - 1].at) : largest;
      if (known[k].size <= 0 || known[k].size > offered) known[k].size = std::min(offered, largest);
    }
    std::reverse(known.begin(), known.end());
    for (auto& stop : known) stop.at = -stop.at;
  }
  std::vector<double> lines;
  for (std::size_t k = 0; k + 1 < known.size(); ++k) {
    lines.push_back(known[k].at);
    fill({known[k], known[k + 1], slope, largest}, lines);
  }
  lines.push_back(known.back().at);
  return lines;
}

Mesh tensor_mesh(const std::vector<double>& x, const std::vector<double>& y,
                 const std::function<int(double, double)>& region, GridSides zero) {
  Mesh m;
  const int columns = static_cast<int>(x.size()), rows = static_cast<int>(y.size());
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      m.x.push_back(x[static_cast<std::size_t>(i)]);
      m.y.push_back(y[static_cast<std::size_t>(j)]);
      m.zero.push_back((zero.left && i == 0) || (zero.right && i + 1 == columns) || (zero.bottom && j == 0) ||
                       (zero.top && j + 1 == rows));
    }
  const auto add = [&](int a, int b, int c, int r) {
    m.triangle.push_back({a, b, c});
    m.region.push_back(r);
  };
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i) {
      const auto si = static_cast<std::size_t>(i), sj = static_cast<std::size_t>(j);
      const int r = region(0.5 * (x[si] + x[si + 1]), 0.5 * (y[sj] + y[sj + 1]));
      if (r < 0) continue;
      const int a = j * columns + i, b = a + 1, c = b + columns, d = a + columns;
      if ((i + j) % 2 == 0) {
        add(a, b, c, r);
        add(a, c, d, r);
      } else {
        add(a, b, d, r);
        add(b, c, d, r);
      }
    }
  return m;
}

}  // namespace powbench::sim
