#include "sim/magnetics/plane/pull_form.h"

#include <array>

#include "sim/dot.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::sim {
namespace {

std::size_t at_place(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

PullForm::PullForm(const FieldSpace& space, const std::vector<double>& weight) {
  const Mesh& m = space.mesh;
  std::vector<double> values(space.pattern.row.size() + 1, 0);
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    const auto& v = m.triangle[t];
    const std::array<double, 3> w{weight[at_place(v[0])], weight[at_place(v[1])], weight[at_place(v[2])]};
    if (w[0] == w[1] && w[1] == w[2]) continue;
    double dx = 0, dy = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = at_place(v[(k + 1) % 3]), q = at_place(v[(k + 2) % 3]);
      dx += w[k] * (m.y[p] - m.y[q]) / twice_area(m, v);
      dy += w[k] * (m.x[q] - m.x[p]) / twice_area(m, v);
    }
    const int* const to = element_positions(space, t);
    for (const auto& p : shape_points(space, t, space.axisymmetric ? 4 : space.order)) {
      const double scale = 0.5 * p.weight / mu0;
      for (std::size_t i = 0, next = 0; i < at_place(space.nodes); ++i)
        for (std::size_t j = 0; j <= i; ++j, ++next)
          values[at_place(to[next])] +=
              scale * ((p.curl_y[i] * p.curl_y[j] - p.curl_x[i] * p.curl_x[j]) * dy +
                       (p.curl_x[i] * p.curl_y[j] + p.curl_y[i] * p.curl_x[j]) * dx);
    }
  }
  const Pattern& pattern = space.pattern;
  for (int j = 0; j < pattern.size; ++j)
    for (int at = pattern.start[at_place(j)]; at < pattern.start[at_place(j) + 1]; ++at)
      if (const double v = values[at_place(at)]; v != 0)
        entries_.push_back({pattern.row[at_place(at)], j, v});
}

/// Sums by rows: the entries of one row nearly cancel.
double PullForm::force(const std::vector<double>& a, std::vector<double>& slope) const {
  slope.assign(a.size(), 0);
  for (const auto& e : entries_) {
    slope[at_place(e.row)] += e.value * a[at_place(e.column)];
    if (e.row != e.column) slope[at_place(e.column)] += e.value * a[at_place(e.row)];
  }
  const double force = dot(a, slope);
  for (double& s : slope) s *= 2;
  return force;
}

double PullForm::force(const std::vector<double>& a) const {
  std::vector<double> slope;
  return force(a, slope);
}

}  // namespace powbench::sim
