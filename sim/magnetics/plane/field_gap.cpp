// The gap of a FieldProblem: the strip that stretches, derivatives of the energy by its height, and forces.

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/magnetics/circuit/magnetic_circuit.h"
#include "sim/magnetics/plane/field_problem.h"

namespace powbench::sim {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// One point of the quadrature in steel that stretches: the field there, H(B) and what it changes with.
struct Stretched {
  double weight;        ///< m3, true
  const double* curls;  ///< lanes x curl_x, lanes x curl_y
  const int* unknowns;
  double bx, energy, hx, hy, hx_x, hx_y;
};

}  // namespace

void FieldProblem::set_gap(double height) {
  if (!(height > 0))
    throw std::invalid_argument("gap of the field = " + std::to_string(height) + " m, must be above 0");
  gap_ = height;
  ++linear_version_;
  linear_ = fixed_;
  stretch_steel();
  const double stretch = height / setup_.strip_height;
  for (const auto& e : strip_) linear_[index(e.at)] += stretch * e.y + e.x / stretch;
}

/// The steel in the strip, from its height as meshed to the true one.
void FieldProblem::stretch_steel() {
  if (setup_.strip_steel_region < 0) return;
  const double stretch = gap_ / setup_.strip_height;
  const auto lanes = index(space_.lanes);
  for (std::size_t point = 0; point < weights_.size(); ++point) {
    const auto& e = elements_[point / index(points_)];
    if (space_.mesh.region[e.triangle] != setup_.strip_steel_region) continue;
    weights_[point] = meshed_weights_[point] * stretch;
    for (std::size_t n = 0; n < lanes; ++n)
      curls_[point * 2 * lanes + n] = meshed_curls_[point * 2 * lanes + n] / stretch;
  }
}

template <class Visit>
void FieldProblem::each_stretched(const double* a, const Visit& visit) const {
  if (setup_.strip_steel_region < 0) return;
  const auto lanes = index(space_.lanes);
  for (std::size_t point = 0; point < weights_.size(); ++point) {
    const auto& e = elements_[point / index(points_)];
    if (space_.mesh.region[e.triangle] != setup_.strip_steel_region) continue;
    const double* const curls = curls_.data() + point * 2 * lanes;
    const int* const u = space_.unknowns(e.triangle);
    double bx = 0, by = 0;
    for (std::size_t n = 0; n < index(space_.nodes); ++n) {
      bx += curls[n] * a[u[n]];
      by += curls[lanes + n] * a[u[n]];
    }
    const double square = bx * bx + by * by, b = std::sqrt(square);
    const SteelPoint p = setup_.steels[index(e.steel)].at(b);
    const double nu = b > 0 ? p.h / b : p.dh_db, extra = square > 0 ? (p.dh_db - nu) / square : 0;
    visit(Stretched{weights_[point], curls, u, bx, p.energy, nu * bx, nu * by, nu + extra * bx * bx,
                    extra * bx * by});
  }
}

/// y += (by_x K_x + by_y K_y) a, from differences of a: a strip of 1 um is meshed as high as one of 1 mm, so what a
/// common part of a adds and takes away again would leave (1000)^2 times the rounding of the rest.
void FieldProblem::add_strip(const double* a, double by_x, double by_y, double* y) const {
  for (const auto& e : strip_) {
    if (e.row == e.column) continue;
    const double change = (by_x * e.x + by_y * e.y) * (a[e.column] - a[e.row]);
    y[e.row] += change;
    y[e.column] -= change;
  }
  for (const auto& e : strip_rest_) y[e.row] += (by_x * e.x + by_y * e.y) * a[e.row];
}

/// a^T (by_x K_x + by_y K_y) a / 2.
double FieldProblem::strip_energy(const double* a, double by_x, double by_y) const {
  double sum = 0;
  for (const auto& e : strip_) {
    if (e.row == e.column) continue;
    const double apart = a[e.row] - a[e.column];
    sum -= (by_x * e.x + by_y * e.y) * apart * apart;
  }
  for (const auto& e : strip_rest_) sum += (by_x * e.x + by_y * e.y) * a[e.row] * a[e.row];
  return 0.5 * sum;
}

void FieldProblem::gap_gradient(const double* a, double* y) const {
  std::fill(y, y + size() + 1, 0.0);
  const double h = setup_.strip_height;
  add_strip(a, -h / (gap_ * gap_), 1 / h, y);
  const auto lanes = index(space_.lanes);
  each_stretched(a, [&](const Stretched& s) {
    for (std::size_t n = 0; n < index(space_.nodes); ++n) {
      const double x = s.curls[n], along = s.curls[lanes + n];
      y[s.unknowns[n]] += s.weight / gap_ * (s.hy * along - s.bx * (s.hx_x * x + s.hx_y * along));
    }
  });
  y[size()] = 0;
}

double FieldProblem::gap_slope(const double* a) const {
  const double h = setup_.strip_height;
  double sum = strip_energy(a, -h / (gap_ * gap_), 1 / h);
  each_stretched(a, [&](const Stretched& s) { sum += s.weight / gap_ * (s.energy - s.hx * s.bx); });
  return sum;
}

double FieldProblem::gap_curvature(const double* a) const {
  double sum = 2 * strip_energy(a, setup_.strip_height / (gap_ * gap_ * gap_), 0);
  each_stretched(a, [&](const Stretched& s) { sum += s.weight / (gap_ * gap_) * s.hx_x * s.bx * s.bx; });
  return sum;
}

double FieldProblem::stress_force(const double* a, const std::vector<double>& weight) const {
  const Mesh& m = space_.mesh;
  double force = 0;
  for (std::size_t t = 0; t < m.triangle.size(); ++t) {
    const auto& v = m.triangle[t];
    const std::array<double, 3> w{weight[index(v[0])], weight[index(v[1])], weight[index(v[2])]};
    if (w[0] == w[1] && w[1] == w[2]) continue;
    const double inverse = 1 / twice_area(m, v);
    double dx = 0, dy = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = index(v[(k + 1) % 3]), q = index(v[(k + 2) % 3]);
      dx += w[k] * (m.y[p] - m.y[q]) * inverse;
      dy += w[k] * (m.x[q] - m.x[p]) * inverse;
    }
    const bool strip = m.region[t] == setup_.strip_region;
    const bool iron = m.region[t] >= 0 && m.region[t] == setup_.strip_steel_region;
    const double stretch = strip || iron ? gap_ / setup_.strip_height : 1;
    dy /= stretch;
    const int* const u = space_.unknowns(t);
    for (const auto& p : shape_points(space_, t, setup_.axisymmetric ? 4 : setup_.order)) {
      double bx = 0, by = 0;
      for (int n = 0; n < space_.nodes; ++n) {
        bx += p.curl_x[index(n)] * a[u[n]];
        by += p.curl_y[index(n)] * a[u[n]];
      }
      bx /= stretch;
      double energy = 0.5 * (bx * bx + by * by) / mu0, nu = 1 / mu0;
      if (iron) {
        const double b = std::hypot(bx, by);
        const SteelPoint s = setup_.steels[index(setup_.steel_of_region[index(m.region[t])])].at(b);
        energy = s.energy;
        nu = b > 0 ? s.h / b : s.dh_db;
      }
      force += stretch * p.weight * ((energy - nu * bx * bx) * dy + nu * bx * by * dx);
    }
  }
  return -force;
}

}  // namespace powbench::sim
