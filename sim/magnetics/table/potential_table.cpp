#include "sim/magnetics/table/potential_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace powbench::sim {
namespace {

using Quad = double __attribute__((vector_size(32)));
using QuadMemory = double __attribute__((vector_size(32), aligned(8), may_alias));

Quad load(const double* p) {
  return *reinterpret_cast<const QuadMemory*>(p);
}

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Cubic c0 + c1 t + c2 t^2 + c3 t^3 on [0, 1] from values and slopes at both ends.
std::array<double, 4> cubic(double f0, double d0, double f1, double d1) {
  return {f0, d0, 3 * (f1 - f0) - 2 * d0 - d1, 2 * (f0 - f1) + d0 + d1};
}

/// Value and two derivatives of a cubic whose coefficients lie side by side.
struct Value {
  double f, d, dd;
};
Value value_at(Quad c, double s) {
  return {c[0] + s * (c[1] + s * (c[2] + s * c[3])), c[1] + s * (2 * c[2] + s * 3 * c[3]),
          2 * c[2] + s * 6 * c[3]};
}

/// Least value of a cubic on [0, 1].
double least_on_unit(Quad c) {
  double least = std::min(c[0], c[0] + c[1] + c[2] + c[3]);
  const double a = 3 * c[3], b = 2 * c[2];
  const auto visit = [&](double s) {
    if (s > 0 && s < 1) least = std::min(least, value_at(c, s).f);
  };
  if (const double root = b * b - 4 * a * c[1]; root >= 0) {
    const double q = -0.5 * (b + std::copysign(std::sqrt(root), b));
    if (a != 0) visit(q / a);
    if (q != 0) visit(c[1] / q);
  }
  return least;
}

double largest(const std::vector<double>& errors) {
  return errors.empty() ? 0.0 : *std::max_element(errors.begin(), errors.end());
}

void check_axis(const char* name, const std::vector<double>& node, bool from_zero) {
  if (node.size() < 2) throw std::invalid_argument(std::string("table: fewer than two nodes of ") + name);
  if (from_zero && node.front() != 0)
    throw std::invalid_argument(std::string("table: ") + name + " must start at 0");
  for (std::size_t k = 1; k < node.size(); ++k)
    if (!(node[k] > node[k - 1]))
      throw std::invalid_argument(std::string("table: node ") + std::to_string(k) + " of " + name + " = " +
                                  text(node[k]) + " does not ascend");
}

}  // namespace

double PotentialTable::worst_current_error() const {
  return largest(current_error);
}

double PotentialTable::worst_pull_error() const {
  return largest(pull_error);
}

void check_table(const PotentialTable& t) {
  check_axis("psi", t.psi, true);
  check_axis("gap", t.gap, true);
  if (!t.ring.empty()) check_axis("ring", t.ring, false);
  const std::size_t rings = std::max<std::size_t>(1, t.ring.size());
  const std::size_t count = t.psi.size() * rings * t.gap.size();
  const std::size_t air = t.ring.empty() ? 2 : 4;
  if (t.nodes.size() != count * t.values() || t.air.size() != t.gap.size() * air)
    throw std::invalid_argument("table: " + std::to_string(t.nodes.size()) + " values for " +
                                std::to_string(count) + " nodes of " + std::to_string(t.values()));
  if (!std::isfinite(t.ring_ratio) || (t.ring.empty() && t.ring_ratio != 0))
    throw std::invalid_argument("table: ring_ratio = " + text(t.ring_ratio) + " without a ring, must be 0");
  if (!t.steel_field.empty() && t.steel_field.size() != count)
    throw std::invalid_argument("table: " + std::to_string(t.steel_field.size()) + " flux densities for " +
                                std::to_string(count) + " nodes");
  for (const auto* list : {&t.psi, &t.ring, &t.gap, &t.nodes, &t.air, &t.steel_field})
    for (const double value : *list)
      if (!std::isfinite(value)) throw std::invalid_argument("table: a value is not a number");
}

TablePotential::Axis::Axis(std::vector<double> nodes) : node(std::move(nodes)) {
  constexpr int bins = 1024;
  bins_per_unit = bins / (node.back() - node.front());
  int k = 0;
  for (int b = 0; b <= bins; ++b) {
    while (index(k) + 2 < node.size() && node[index(k) + 1] <= node.front() + b / bins_per_unit) ++k;
    bin.push_back(k);
  }
}

int TablePotential::Axis::cell(double x) const {
  int k = bin[static_cast<std::size_t>((x - node.front()) * bins_per_unit)];
  while (index(k) + 2 < node.size() && node[index(k) + 1] <= x) ++k;
  return k;
}

TablePotential::TablePotential(PotentialTable table) : table_(std::move(table)) {
  check_table(table_);
  psi_ = Axis(table_.psi);
  gap_ = Axis(table_.gap);
  if (has_ring()) ring_ = Axis(table_.ring);
  fit_cells();
  check_stiffness();
  fit_reaches();
}

/// Hermite data at the corners of each cell, turned into powers of the unit cell's coordinates, one axis after another.
/// Layout: psi power slowest, gap power fastest.
void TablePotential::fit_cells() {
  const std::size_t np = table_.psi.size(), nr = std::max<std::size_t>(1, table_.ring.size()),
                    ng = table_.gap.size();
  const std::size_t per_node = table_.values();
  const std::size_t ring_ends = has_ring() ? 2 : 1;
  const std::size_t ring_powers = has_ring() ? 4 : 1;
  for (std::size_t g = 0; g + 1 < ng; ++g)
    for (std::size_t r = 0; r < std::max<std::size_t>(1, nr - 1); ++r)
      for (std::size_t p = 0; p + 1 < np; ++p) {
        const double hp = table_.psi[p + 1] - table_.psi[p], hg = table_.gap[g + 1] - table_.gap[g];
        const double hr = has_ring() ? table_.ring[r + 1] - table_.ring[r] : 1;
        // f[gap end, derivative][ring end, derivative] as a cubic in psi
        std::array<std::array<std::array<double, 4>, 4>, 4> f{};
        for (std::size_t eg = 0; eg < 2; ++eg)
          for (std::size_t er = 0; er < ring_ends; ++er)
            for (std::size_t dg = 0; dg < 2; ++dg)
              for (std::size_t dr = 0; dr < ring_ends; ++dr) {
                const auto node = [&](std::size_t ep, std::size_t dp) {
                  const std::size_t n = (p + ep) + np * ((r + er) + nr * (g + eg));
                  const std::size_t at = has_ring() ? dp + 2 * dr + 4 * dg : dp + 2 * dg;
                  return table_.nodes[n * per_node + at] * (dp ? hp : 1) * (dr ? hr : 1) * (dg ? hg : 1);
                };
                f[2 * eg + dg][2 * er + dr] = cubic(node(0, 0), node(0, 1), node(1, 0), node(1, 1));
              }
        for (std::size_t power = 0; power < 4; ++power) {
          std::array<std::array<double, 4>, 4> by_ring{};  // [gap end, derivative][ring power]
          for (std::size_t k = 0; k < 4; ++k) {
            if (has_ring())
              by_ring[k] = cubic(f[k][0][power], f[k][1][power], f[k][2][power], f[k][3][power]);
            else
              by_ring[k][0] = f[k][0][power];
          }
          for (std::size_t rp = 0; rp < ring_powers; ++rp) {
            const auto c = cubic(by_ring[0][rp], by_ring[1][rp], by_ring[2][rp], by_ring[3][rp]);
            cell_.insert(cell_.end(), c.begin(), c.end());
          }
        }
      }
}

MagneticResponse TablePotential::inside2(double psi, double gap) const {
  const int p = psi_.cell(psi), g = gap_.cell(gap);
  const double hp = 1 / (psi_.node[index(p) + 1] - psi_.node[index(p)]);
  const double hg = 1 / (gap_.node[index(g) + 1] - gap_.node[index(g)]);
  const double t = (psi - psi_.node[index(p)]) * hp, s = (gap - gap_.node[index(g)]) * hg;
  const double* const c = cell_.data() + 16 * (index(p) + (psi_.node.size() - 1) * index(g));
  const Quad c0 = load(c), c1 = load(c + 4), c2 = load(c + 8), c3 = load(c + 12);
  const Value w = value_at(c0 + t * (c1 + t * (c2 + t * c3)), s);
  const Value d = value_at(c1 + t * (2 * c2 + t * (3 * c3)), s);
  const Value dd = value_at(2 * c2 + t * (6 * c3), s);
  MagneticResponse r;
  r.energy = w.f;
  r.pull = w.d * hg;
  r.pull_gap = w.dd * hg * hg;
  r.current = d.f * hp;
  r.current_gap = d.d * hp * hg;
  r.current_psi = dd.f * hp * hp;
  return r;
}

MagneticResponse TablePotential::inside3(double psi, double ring, double gap) const {
  const int p = psi_.cell(psi), q = ring_.cell(ring), g = gap_.cell(gap);
  const double hp = 1 / (psi_.node[index(p) + 1] - psi_.node[index(p)]);
  const double hr = 1 / (ring_.node[index(q) + 1] - ring_.node[index(q)]);
  const double hg = 1 / (gap_.node[index(g) + 1] - gap_.node[index(g)]);
  const double t = (psi - psi_.node[index(p)]) * hp, u = (ring - ring_.node[index(q)]) * hr;
  const double s = (gap - gap_.node[index(g)]) * hg;
  const std::size_t cells_p = psi_.node.size() - 1, cells_r = ring_.node.size() - 1;
  const double* const c = cell_.data() + 64 * (index(p) + cells_p * (index(q) + cells_r * index(g)));
  Quad f[4], d[4], dd[4];  // by power of the ring: value and psi derivatives, over the powers of the gap
  for (std::size_t k = 0; k < 4; ++k) {
    const Quad c0 = load(c + 4 * k), c1 = load(c + 16 + 4 * k), c2 = load(c + 32 + 4 * k),
               c3 = load(c + 48 + 4 * k);
    f[k] = c0 + t * (c1 + t * (c2 + t * c3));
    d[k] = c1 + t * (2 * c2 + t * (3 * c3));
    dd[k] = 2 * c2 + t * (6 * c3);
  }
  const Value w = value_at(f[0] + u * (f[1] + u * (f[2] + u * f[3])), s);
  const Value wr = value_at(f[1] + u * (2 * f[2] + u * (3 * f[3])), s);
  const Value wrr = value_at(2 * f[2] + u * (6 * f[3]), s);
  const Value wp = value_at(d[0] + u * (d[1] + u * (d[2] + u * d[3])), s);
  const Value wpr = value_at(d[1] + u * (2 * d[2] + u * (3 * d[3])), s);
  const Value wpp = value_at(dd[0] + u * (dd[1] + u * (dd[2] + u * dd[3])), s);
  MagneticResponse r;
  r.energy = w.f;
  r.current = wp.f * hp;
  r.ring_current = wr.f * hr;
  r.pull = w.d * hg;
  r.current_psi = wpp.f * hp * hp;
  r.current_ring = wpr.f * hp * hr;
  r.ring_ring = wrr.f * hr * hr;
  r.current_gap = wp.d * hp * hg;
  r.ring_gap = wr.d * hr * hg;
  r.pull_gap = w.dd * hg * hg;
  return r;
}

/// Inverse inductances of air at a gap with two derivatives by the gap: coil, or coil and ring.
MagneticResponse TablePotential::at(const MagneticState& state) const {
  // without flux in the coil the ring's sign decides, so that both polarities are one evaluation
  const double ratio = table_.ring_ratio;
  const double first = ratio == 0 ? state.psi : state.psi - ratio * state.ring;
  const double sign = first < 0 || (first == 0 && has_ring() && state.ring < 0) ? -1 : 1;
  const double psi = sign * first, ring = has_ring() ? sign * state.ring : 0;
  if (!std::isfinite(psi) || !std::isfinite(state.gap) || !std::isfinite(ring)) {
    const double nan = psi + ring + state.gap;
    return {nan, nan, nan, nan, nan, nan, nan, nan, nan, nan};
  }
  const double gap = std::max(state.gap, 0.0);
  MagneticResponse r;
  if (psi > psi_.node.back() || gap > gap_.node.back() ||
      (has_ring() && (ring < ring_.node.front() || ring > ring_.node.back()))) {
    r = outside(psi, ring, gap);
    r.beyond = true;
  } else {
    r = has_ring() ? inside3(psi, ring, gap) : inside2(psi, gap);
  }
  if (const double pressed = state.gap - gap; pressed != 0) {  // straight on
    r.energy += r.pull * pressed;
    r.current += r.current_gap * pressed;
    r.ring_current += r.ring_gap * pressed;
    r.pull_gap = 0;
  }
  const bool dead = psi == 0 && ring == 0;  // no flux, no current: to the last bit, whatever the nodes say
  if (dead) r.current = r.ring_current = r.current_gap = r.ring_gap = 0;
  if (ratio != 0) {  // from the derivatives of V to those of W
    r.ring_ring += ratio * (ratio * r.current_psi - 2 * r.current_ring);
    r.current_ring -= ratio * r.current_psi;
    r.ring_current -= ratio * r.current;
    r.ring_gap -= ratio * r.current_gap;
  }
  r.current *= sign;
  r.ring_current *= sign;
  r.current_gap *= sign;
  r.ring_gap *= sign;
  return r;
}

void TablePotential::check_stiffness() {
  least_stiffness_ = 1e300;
  const std::size_t np = psi_.node.size() - 1, nr = has_ring() ? ring_.node.size() - 1 : 1;
  const auto look = [&](double value, std::size_t p, std::size_t r, std::size_t g) {
    least_stiffness_ = std::min(least_stiffness_, value);
    if (value > 0) return;
    throw std::invalid_argument(
        "table: di/dpsi = " + text(value) + " A/Wb in the cell from psi = " + text(psi_.node[p]) +
        " Wb, gap = " + text(gap_.node[g] * 1e3) + " mm" +
        (has_ring() ? ", ring flux = " + text(ring_.node[r]) + " Wb" : "") +
        ", must be above 0: more nodes are needed: a smaller accuracy, or a lower largest flux");
  };
  for (std::size_t g = 0; g + 1 < gap_.node.size(); ++g)
    for (std::size_t r = 0; r < nr; ++r)
      for (std::size_t p = 0; p < np; ++p) {
        const double h = 1 / (psi_.node[p + 1] - psi_.node[p]);
        const double* const c = cell_.data() + (has_ring() ? 64 : 16) * (p + np * (r + nr * g));
        if (!has_ring()) {
          for (const double t : {0.0, 1.0})
            look(least_on_unit(2 * load(c + 8) + (6 * t) * load(c + 12)) * h * h, p, r, g);
          continue;
        }
        for (const double t : {0.0, 1.0})
          for (const double u : {0.0, 1. / 3, 2. / 3, 1.0}) {
            Quad sum{};
            for (int k = 3; k >= 0; --k)
              sum = sum * u + 2 * load(c + 32 + 4 * k) + (6 * t) * load(c + 48 + 4 * k);
            look(least_on_unit(sum) * h * h, p, r, g);
          }
      }
}

}  // namespace powbench::sim
