#include "bench/fields/bilinear.h"

#include <algorithm>
#include <cmath>

namespace powbench::bench {
namespace {

/// The node below x, so that x lies in [k, k + 1] or outside of all.
std::size_t cell(const std::vector<double>& nodes, double x) {
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, x);
  return static_cast<std::size_t>(above - nodes.begin()) - 1;
}

double share(const std::vector<double>& nodes, std::size_t k, double x) {
  return (x - nodes[k]) / (nodes[k + 1] - nodes[k]);
}

}  // namespace

BilinearTables::BilinearTables(sim::MagnetField& field, int n, double largest_current, double largest_gap) {
  constexpr double grade = 0.3e-3;
  for (int k = 0; k < n; ++k) {
    const double s = static_cast<double>(k) / (n - 1);
    current_.push_back(largest_current * std::pow(s, 1.5));
    gap_.push_back(grade * std::expm1(s * std::log1p(largest_gap / grade)));
  }
  for (const double gap : gap_) {
    field.set_gap(gap);
    std::vector<double> start;
    for (const double current : current_) {
      auto p = field.at_current(current, 0, std::move(start));
      flux_.push_back(field.fluxes(p).first);
      pull_.push_back(p.response.pull);
      start = std::move(p.a);
    }
  }
}

double BilinearTables::at_node(const std::vector<double>& table, std::size_t i, double gap) const {
  const std::size_t g = cell(gap_, gap), n = current_.size();
  const double t = share(gap_, g, gap);
  return (1 - t) * table[g * n + i] + t * table[(g + 1) * n + i];
}

double BilinearTables::value(const std::vector<double>& table, double current, double gap) const {
  const std::size_t i = cell(current_, current);
  const double t = share(current_, i, current);
  return (1 - t) * at_node(table, i, gap) + t * at_node(table, i + 1, gap);
}

sim::MagneticResponse BilinearTables::at(const sim::MagneticState& s) const {
  const double psi = std::fabs(s.psi);
  std::size_t low = 0, high = current_.size() - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (at_node(flux_, middle, s.gap) <= psi ? low : high) = middle;
  }
  const double from = at_node(flux_, low, s.gap), to = at_node(flux_, low + 1, s.gap);
  sim::MagneticResponse r;
  r.current_psi = (current_[low + 1] - current_[low]) / (to - from);
  const double current = current_[low] + (psi - from) * r.current_psi;
  r.current = std::copysign(current, s.psi);
  r.pull = pull(current, s.gap);
  return r;
}

double loop_gain(const sim::MagneticPotential& p, double psi_low, double psi_high, double gap_low,
                 double gap_high, int steps) {
  double gain = 0, work = 0;
  for (int k = 0; k < steps; ++k) {
    const double t = (k + 0.5) / steps;
    const double psi = psi_low + t * (psi_high - psi_low), gap = gap_low + t * (gap_high - gap_low);
    const double dpsi = (psi_high - psi_low) / steps, dgap = (gap_high - gap_low) / steps;
    const double electrical = (p.at({psi, 0, gap_high}).current - p.at({psi, 0, gap_low}).current) * dpsi;
    const double mechanical = (p.at({psi_high, 0, gap}).pull - p.at({psi_low, 0, gap}).pull) * dgap;
    gain += electrical - mechanical;
    work += std::fabs(electrical);
  }
  return gain / work;
}

}  // namespace powbench::bench
