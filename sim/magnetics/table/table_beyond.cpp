#include <algorithm>
#include <cmath>

#include "sim/magnetics/table/potential_table.h"

/// What a table answers outside of its nodes.

namespace powbench::sim {
namespace {

/// The powers of t and their derivatives of order 0 .. 2; `h` = dt/dx.
struct Powers {
  double at[3][4];
  Powers(double t, double h)
      : at{{1, t, t * t, t * t * t}, {0, h, 2 * t * h, 3 * t * t * h}, {0, 0, 2 * h * h, 6 * t * h * h}} {}
};

/// q'' = 1 / (1 + o/p)^2 and its integrals from 0: the share of the steel that is not yet air.
struct Fade {
  double q, slope, bend;
  Fade(double over, double reach)
      : q(reach * over - reach * reach * std::log1p(over / reach)),
        slope(over / (1 + over / reach)),
        bend(1 / ((1 + over / reach) * (1 + over / reach))) {}
};

/// One function with two derivatives at an edge, carried on by `over` >= 0 towards the curvature `air`.
void carry_on(double& f, double& slope, double& bend, double air, double over, const Fade& fade) {
  f += slope * over + air * (0.5 * over * over - fade.q) + bend * fade.q;
  slope += air * (over - fade.slope) + bend * fade.slope;
  bend = air * (1 - fade.bend) + bend * fade.bend;
}

/// A function of the gap behind the last one: its slope fades as 1/(1 + x/d)^2 where it already does so at the edge.
void carry_gap(double& f, double& slope, double& bend, double x, double d) {
  const double u = 1 / (1 + x / d), u2 = u * u;
  const double first = d * (3 * (1 - u) - (1 - u2));         // integral of 3 u^2 - 2 u^3
  const double second = d * d * ((1 - u) - 0.5 * (1 - u2));  // integral of d (u^2 - u^3)
  f += slope * first + bend * second;
  const double s = slope;
  slope = s * (3 * u2 - 2 * u2 * u) + bend * d * (u2 - u2 * u);
  bend = -6 * s * u2 * u * (1 - u) / d + bend * u2 * u * (3 * u - 2);
}

/// From currents at both ends of the last cell and the stiffness at its end: the length in which the steel gives way
/// to air.
double reach_of(double width, double first, double last, double stiffness, double air) {
  const double ratio = (air - (last - first) / width) / (air - stiffness);
  return air > stiffness && ratio > 1 ? width * ratio / (ratio - 1) : 0;
}

double median(std::vector<double> values, double otherwise) {
  std::erase_if(values, [](double v) { return !(v > 0); });
  if (values.empty()) return otherwise;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

TablePotential::Jet TablePotential::jet(double psi, double ring, double gap) const {
  const auto place = [](const Axis& axis, double x, std::size_t& cell) {
    cell = static_cast<std::size_t>(axis.cell(x));
    const double h = 1 / (axis.node[cell + 1] - axis.node[cell]);
    return Powers((x - axis.node[cell]) * h, h);
  };
  std::size_t p = 0, q = 0, g = 0;
  const Powers by_psi = place(psi_, psi, p), by_gap = place(gap_, gap, g);
  const Powers by_ring = has_ring() ? place(ring_, ring, q) : Powers(0, 0);
  const std::size_t rings = has_ring() ? 4 : 1, cells_r = has_ring() ? ring_.node.size() - 1 : 1;
  const double* const c =
      cell_.data() + 16 * (has_ring() ? 4 : 1) * (p + (psi_.node.size() - 1) * (q + cells_r * g));
  Jet j;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < (has_ring() ? 3U : 1U); ++b)
      for (std::size_t d = 0; d < 3; ++d)
        for (std::size_t k = 0; k < 4; ++k)
          for (std::size_t l = 0; l < rings; ++l)
            for (std::size_t m = 0; m < 4; ++m)
              j.w[a][b][d] +=
                  c[(k * rings + l) * 4 + m] * by_psi.at[a][k] * by_ring.at[b][l] * by_gap.at[d][m];
  return j;
}

/// Inverse inductance of air of the coil (0) or the ring (1) with its derivatives by the gap.
void TablePotential::air_at(double gap, std::size_t winding, double (&gamma)[3]) const {
  const std::size_t count = has_ring() ? 2 : 1;
  const auto g = static_cast<std::size_t>(gap_.cell(gap));
  const double h = gap_.node[g + 1] - gap_.node[g];
  const double* const a = table_.air.data() + 2 * (g * count + winding);
  const double* const b = a + 2 * count;
  const double c2 = 3 * (b[0] - a[0]) - (2 * a[1] + b[1]) * h, c3 = 2 * (a[0] - b[0]) + (a[1] + b[1]) * h;
  const Powers s((gap - gap_.node[g]) / h, 1 / h);
  for (std::size_t k = 0; k < 3; ++k)
    gamma[k] = a[0] * s.at[k][0] + a[1] * h * s.at[k][1] + c2 * s.at[k][2] + c3 * s.at[k][3];
}

MagneticResponse TablePotential::outside(double psi, double ring, double gap) const {
  const double edge_psi = std::min(psi, psi_.node.back()), edge_gap = std::min(gap, gap_.node.back());
  const double edge_ring = has_ring() ? std::clamp(ring, ring_.node.front(), ring_.node.back()) : 0;
  Jet j = jet(edge_psi, edge_ring, edge_gap);
  auto& w = j.w;
  double air[3];
  if (const double over = psi - edge_psi; over > 0) {
    air_at(edge_gap, 0, air);
    const Fade fade(over, flux_reach_);
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t d = 0; d < 3; ++d)
        carry_on(w[0][b][d], w[1][b][d], w[2][b][d], b == 0 ? air[d] : 0, over, fade);
  }
  if (const double over = std::fabs(ring - edge_ring); over > 0) {
    air_at(edge_gap, 1, air);
    const Fade fade(over, ring_reach_);
    const double side = ring < edge_ring ? -1 : 1;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t d = 0; d < 3; ++d) {
        double slope = side * w[a][1][d];
        carry_on(w[a][0][d], slope, w[a][2][d], a == 0 ? air[d] : 0, over, fade);
        w[a][1][d] = side * slope;
      }
  }
  if (const double x = gap - edge_gap; x > 0)
    for (auto& by_psi : w)
      for (auto& by_ring : by_psi) carry_gap(by_ring[0], by_ring[1], by_ring[2], x, gap_reach_);
  MagneticResponse r;
  r.energy = w[0][0][0];
  r.current = w[1][0][0];
  r.ring_current = w[0][1][0];
  r.pull = w[0][0][1];
  r.current_psi = w[2][0][0];
  r.current_ring = w[1][1][0];
  r.ring_ring = w[0][2][0];
  r.current_gap = w[1][0][1];
  r.ring_gap = w[0][1][1];
  r.pull_gap = w[0][0][2];
  return r;
}

void TablePotential::fit_reaches() {
  fit_flux_reach();
  fit_gap_reach();
}

void TablePotential::fit_flux_reach() {
  constexpr double least = 0.05, most = 2;  // of the last node
  std::vector<double> reaches, ring_reaches;
  double air[3];
  const double end = psi_.node.back(), before = psi_.node[psi_.node.size() - 2];
  for (const double gap : gap_.node) {
    air_at(gap, 0, air);
    const Jet a = jet(before, 0, gap), b = jet(end, 0, gap);
    reaches.push_back(reach_of(end - before, a.w[1][0][0], b.w[1][0][0], b.w[2][0][0], air[0]));
    if (!has_ring()) continue;
    air_at(gap, 1, air);
    const double r1 = ring_.node.back(), r0 = ring_.node[ring_.node.size() - 2];
    const Jet c = jet(0, r0, gap), d = jet(0, r1, gap);
    ring_reaches.push_back(reach_of(r1 - r0, c.w[0][1][0], d.w[0][1][0], d.w[0][2][0], air[0]));
  }
  flux_reach_ = std::clamp(median(reaches, 0.5 * end), least * end, most * end);
  if (!has_ring()) return;
  const double ring_end = ring_.node.back();
  ring_reach_ = std::clamp(median(ring_reaches, 0.5 * ring_end), least * ring_end, most * ring_end);
}

/// The length of the last two gaps' pulls; shorter where a pull would turn round or d2W/dpsi2 would fall to 0 far out.
void TablePotential::fit_gap_reach() {
  const double end = gap_.node.back(), before = gap_.node[gap_.node.size() - 2];
  constexpr double turns = 3;  // a pull that falls faster than 3 F / d changes its sign
  std::vector<double> reaches;
  double longest = 10 * end;
  std::vector<Jet> edge;
  for (const double psi : psi_.node) {
    const Jet a = jet(psi, 0, before), b = jet(psi, 0, end);
    edge.push_back(b);
    const double pull = b.w[0][0][1], fall = -b.w[0][0][2];
    if (!(pull > 0)) continue;
    const double ratio = std::sqrt(std::max(a.w[0][0][1] / pull, 0.0));
    if (ratio > 1) reaches.push_back((end - before) * ratio / (ratio - 1));
    if (fall > 0) longest = std::min(longest, turns * pull / fall);
  }
  gap_reach_ = std::min(median(reaches, 0.5 * end), longest);
  const auto stiff = [&] {
    for (const Jet& j : edge)
      for (const double x : {0.1, 0.3, 1.0, 3.0, 10.0, 1e3}) {
        double s = j.w[2][0][0], slope = j.w[2][0][1], bend = j.w[2][0][2];
        carry_gap(s, slope, bend, x * gap_reach_, gap_reach_);
        if (!(s > 0)) return false;
      }
    return true;
  };
  for (int k = 0; k < 30 && !stiff(); ++k) gap_reach_ *= 0.5;
}

}  // namespace powbench::sim
