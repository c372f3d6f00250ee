#include "sim/magnetics/plane/field_problem.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::sim {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The nodes of an element side by side.
template <int lanes>
struct Lanes;
template <>
struct Lanes<4> {
  using Vector = double __attribute__((vector_size(32)));
  using Unaligned = double __attribute__((vector_size(32), aligned(8), may_alias));
};
template <>
struct Lanes<8> {
  using Vector = double __attribute__((vector_size(64)));
  using Unaligned = double __attribute__((vector_size(64), aligned(8), may_alias));
};

template <class T>
T of_region(const std::vector<T>& table, int region, T otherwise) {
  return region >= 0 && index(region) < table.size() ? table[index(region)] : otherwise;
}

}  // namespace

FieldProblem::FieldProblem(Mesh mesh, FieldSetup setup)
    : setup_(std::move(setup)),
      space_(make_space(std::move(mesh), setup_.order, setup_.axisymmetric, setup_.depth)) {
  sort_elements();
  build_steel();
  build_linear();
  build_windings();
  set_gap(setup_.strip_height);
}

void FieldProblem::set_steels(std::vector<Steel> steels) {
  assert(steels.size() == setup_.steels.size());
  setup_.steels = std::move(steels);
}

void FieldProblem::move_vertices(std::vector<double> x, std::vector<double> y) {
  Mesh& m = space_.mesh;
  if (x.size() != m.x.size() || y.size() != m.y.size())
    throw std::invalid_argument("mesh: " + std::to_string(x.size()) + " places for " +
                                std::to_string(m.x.size()) + " vertices");
  m.x = std::move(x);
  m.y = std::move(y);
  for (const auto& t : m.triangle)
    if (!(twice_area(m, t) > 0)) throw std::invalid_argument("mesh: a triangle turns over as vertices move");
  place_unknowns(space_);
  build_steel();
  build_linear();
  build_windings();
  set_gap(gap_);
}

void FieldProblem::sort_elements() {
  const auto& region = space_.mesh.region;
  for (std::size_t t = 0; t < region.size(); ++t)
    if (const int steel = of_region(setup_.steel_of_region, region[t], -1); steel >= 0)
      elements_.push_back({t, steel});
  // neighbours in the order of elimination are neighbours in the matrix: what they add to is in the cache
  const auto first = [&](const SteelElement& e) {
    const int* const u = space_.unknowns(e.triangle);
    return *std::min_element(u, u + space_.nodes);
  };
  std::stable_sort(elements_.begin(), elements_.end(),
                   [&](const SteelElement& a, const SteelElement& b) { return first(a) < first(b); });
}

void FieldProblem::build_steel() {
  curls_.clear();
  weights_.clear();
  centre_curls_.clear();
  const int degree = setup_.axisymmetric ? 4 : setup_.order;
  const auto lanes = index(space_.lanes);
  for (const auto& e : elements_) {
    const auto points = shape_points(space_, e.triangle, degree);
    points_ = static_cast<int>(points.size());
    const auto centre = shape_at(space_, e.triangle, {1. / 3, 1. / 3, 1. / 3});
    for (std::size_t n = 0; n < index(space_.nodes); ++n)
      centre_curls_.insert(centre_curls_.end(), {centre.curl_x[n], centre.curl_y[n]});
    for (const auto& p : points) {
      weights_.push_back(p.weight);
      curls_.insert(curls_.end(), p.curl_x.begin(), p.curl_x.begin() + static_cast<std::ptrdiff_t>(lanes));
      curls_.insert(curls_.end(), p.curl_y.begin(), p.curl_y.begin() + static_cast<std::ptrdiff_t>(lanes));
    }
  }
  if (setup_.strip_steel_region < 0) return;
  meshed_curls_ = curls_;
  meshed_weights_ = weights_;
}

void FieldProblem::build_linear() {
  const std::size_t entries = space_.pattern.row.size() + 1;
  fixed_.assign(entries, 0);
  std::vector<double> strip_x, strip_y;
  strip_.clear();
  if (setup_.strip_region >= 0) {
    strip_x.assign(entries, 0);
    strip_y.assign(entries, 0);
  }
  if (std::any_of(setup_.conductivity.begin(), setup_.conductivity.end(), [](double s) { return s > 0; }))
    mass_.assign(entries, 0);
  const int degree = setup_.axisymmetric ? 4 : setup_.order;
  for (std::size_t t = 0; t < space_.mesh.triangle.size(); ++t) {
    const int region = space_.mesh.region[t];
    const bool linear = of_region(setup_.steel_of_region, region, -1) < 0;
    const double conductivity = of_region(setup_.conductivity, region, 0.0);
    const bool strip = region == setup_.strip_region;
    if (!linear && conductivity <= 0) continue;
    const int* const to = element_positions(space_, t);
    const auto add = [&](const ShapePoint& p, const std::array<double, 8>& f, std::vector<double>& values,
                         double scale) {
      for (int i = 0, at = 0; i < space_.nodes; ++i)
        for (int j = 0; j <= i; ++j, ++at)
          values[index(to[at])] += p.weight * scale * f[index(i)] * f[index(j)];
    };
    for (const auto& p : shape_points(space_, t, degree)) {
      if (!linear) break;
      add(p, p.curl_x, strip ? strip_x : fixed_, 1 / mu0);
      add(p, p.curl_y, strip ? strip_y : fixed_, 1 / mu0);
    }
    if (conductivity > 0)
      for (const auto& p : shape_points(space_, t, 4)) add(p, p.value, mass_, conductivity);
  }
  if (setup_.strip_region < 0) return;
  const Pattern& pattern = space_.pattern;
  for (int j = 0; j < pattern.size; ++j)
    for (int at = pattern.start[index(j)]; at < pattern.start[index(j) + 1]; ++at)
      if (strip_x[index(at)] != 0 || strip_y[index(at)] != 0)
        strip_.push_back({pattern.row[index(at)], j, at, strip_x[index(at)], strip_y[index(at)]});
  sum_strip_rows();
}

/// No field comes from a potential that is the same everywhere: rows sum up to nothing but beside a given one. (In a
/// cylinder they do not.)
void FieldProblem::sum_strip_rows() {
  constexpr double rounding = 1e-12;
  std::vector<StripEntry> rest(index(size()), StripEntry{}), own = rest;
  const auto add = [&](int row, const StripEntry& e) {
    rest[index(row)].x += e.x;
    rest[index(row)].y += e.y;
  };
  for (const auto& e : strip_) {
    add(e.row, e);
    if (e.row == e.column)
      own[index(e.row)] = e;
    else
      add(e.column, e);
  }
  strip_rest_.clear();
  for (int k = 0; k < size(); ++k) {
    const StripEntry& sum = rest[index(k)];
    const StripEntry& diagonal = own[index(k)];
    const bool by_x = std::fabs(sum.x) > rounding * diagonal.x,
               by_y = std::fabs(sum.y) > rounding * diagonal.y;
    if (by_x || by_y) strip_rest_.push_back({k, k, diagonal.at, by_x ? sum.x : 0, by_y ? sum.y : 0});
  }
}

void FieldProblem::build_windings() {
  windings_.clear();
  for (const auto& w : setup_.windings) {
    std::vector<double> c(index(size()) + 1, 0);
    for (const auto& [region, turns] : w.parts) {
      const double area = region_area(space_.mesh, region);
      if (!(area > 0))
        throw std::invalid_argument("winding: region " + std::to_string(region) + " has no triangle");
      for (std::size_t t = 0; t < space_.mesh.triangle.size(); ++t) {
        if (space_.mesh.region[t] != region) continue;
        for (const auto& p : shape_points(space_, t, setup_.axisymmetric ? 4 : setup_.order))
          for (int n = 0; n < space_.nodes; ++n)
            c[index(space_.unknowns(t)[n])] += p.weight * p.value[index(n)] * turns / area;
      }
    }
    c.back() = 0;
    windings_.push_back(std::move(c));
  }
}

template <int nodes, int lanes>
double FieldProblem::add_steel_by(const double* a, double* gradient, double* values) const {
  using Vector = typename Lanes<lanes>::Vector;
  using Unaligned = typename Lanes<lanes>::Unaligned;
  double energy = 0;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const int* const u = space_.unknowns(elements_[e].triangle);
    const Steel& steel = setup_.steels[index(elements_[e].steel)];
    double local[lanes] = {};
    for (int n = 0; n < nodes; ++n) local[n] = a[u[n]];
    Vector force{};
    Vector hessian[nodes] = {};
    for (int q = 0; q < points_; ++q) {
      const std::size_t point = e * index(points_) + index(q);
      const double* const cx = curls_.data() + point * 2 * lanes;
      const double* const cy = cx + lanes;
      double bx = 0, by = 0;
      for (int n = 0; n < nodes; ++n) {
        bx += cx[n] * local[n];
        by += cy[n] * local[n];
      }
      const double square = bx * bx + by * by;
      const double b = std::sqrt(square);
      const SteelPoint p = steel.at(b);
      const double weight = weights_[point];
      energy += weight * p.energy;
      const double nu = weight * (b > 0 ? p.h / b : p.dh_db);
      const Vector vx = *reinterpret_cast<const Unaligned*>(cx);
      const Vector vy = *reinterpret_cast<const Unaligned*>(cy);
      const Vector along = bx * vx + by * vy;
      force += nu * along;
      if (!values) continue;
      const double extra = square > 0 ? (weight * p.dh_db - nu) / square : 0;
      for (int n = 0; n < nodes; ++n)
        hessian[n] += (nu * cx[n]) * vx + (nu * cy[n]) * vy + (extra * along[n]) * along;
    }
    for (int n = 0; n < nodes; ++n) gradient[u[n]] += force[n];
    if (!values) continue;
    const int* to = element_positions(space_, elements_[e].triangle);
    for (int i = 0; i < nodes; ++i)
      for (int j = 0; j <= i; ++j) values[*to++] += hessian[i][j];
  }
  return energy;
}

double FieldProblem::add_steel(const double* a, double* gradient, double* values) const {
  return space_.order == 1 ? add_steel_by<3, 4>(a, gradient, values)
                           : add_steel_by<6, 8>(a, gradient, values);
}

FieldProblem::Ray::Ray(const FieldProblem& problem, const double* a, const double* d) : problem_(problem) {
  const FieldProblem& p = problem;
  const auto lanes = index(p.space_.lanes);
  b_.reserve(4 * p.weights_.size());
  for (std::size_t point = 0; point < p.weights_.size(); ++point) {
    const int* const u = p.space_.unknowns(p.elements_[point / index(p.points_)].triangle);
    const double* const cx = p.curls_.data() + point * 2 * lanes;
    double sum[4] = {};
    for (std::size_t n = 0; n < index(p.space_.nodes); ++n) {
      sum[0] += cx[n] * a[u[n]];
      sum[1] += cx[lanes + n] * a[u[n]];
      sum[2] += cx[n] * d[u[n]];
      sum[3] += cx[lanes + n] * d[u[n]];
    }
    b_.insert(b_.end(), sum, sum + 4);
  }
}

double FieldProblem::Ray::steel_energy(double s) const {
  double energy = 0;
  for (std::size_t point = 0; point < problem_.weights_.size(); ++point) {
    const double* const b = b_.data() + 4 * point;
    const double bx = b[0] + s * b[2], by = b[1] + s * b[3];
    const auto& steel =
        problem_.setup_.steels[index(problem_.elements_[point / index(problem_.points_)].steel)];
    energy += problem_.weights_[point] * steel.at(std::sqrt(bx * bx + by * by)).energy;
  }
  return energy;
}

std::vector<char> FieldProblem::steel_unknowns() const {
  std::vector<char> out(index(size()) + 1, 0);
  for (const auto& e : elements_)
    for (int n = 0; n < space_.nodes; ++n) out[index(space_.unknowns(e.triangle)[n])] = 1;
  out.back() = 0;
  return out;
}

/// Square of B in the middle of a steel element.
double FieldProblem::centre_square(std::size_t element, const double* a) const {
  const std::size_t triangle = elements_[element].triangle;
  const int* const u = space_.unknowns(triangle);
  const double* curls = centre_curls_.data() + element * 2 * index(space_.nodes);
  double bx = 0, by = 0;
  for (int n = 0; n < space_.nodes; ++n) {
    bx += *curls++ * a[u[n]];
    by += *curls++ * a[u[n]];
  }
  if (setup_.strip_steel_region >= 0 && space_.mesh.region[triangle] == setup_.strip_steel_region)
    bx *= setup_.strip_height / gap_;
  return bx * bx + by * by;
}

double FieldProblem::largest_field(const double* a) const {
  double largest = 0;
  for (std::size_t e = 0; e < elements_.size(); ++e) largest = std::max(largest, centre_square(e, a));
  return std::sqrt(largest);
}

double FieldProblem::share_beyond_data(const double* a) const {
  double above = 0, whole = 0;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    double volume = 0;
    for (int q = 0; q < points_; ++q) volume += weights_[e * index(points_) + index(q)];
    whole += volume;
    const double end = setup_.steels[index(elements_[e].steel)].data_end();
    if (centre_square(e, a) > end * end) above += volume;
  }
  return whole > 0 ? above / whole : 0;
}

std::pair<double, double> FieldProblem::field(std::size_t triangle, const std::array<double, 3>& l,
                                              const double* a) const {
  const ShapePoint p = shape_at(space_, triangle, l);
  const int* const u = space_.unknowns(triangle);
  double bx = 0, by = 0;
  for (int n = 0; n < space_.nodes; ++n) {
    bx += p.curl_x[index(n)] * a[u[n]];
    by += p.curl_y[index(n)] * a[u[n]];
  }
  const int region = space_.mesh.region[triangle];
  if (region >= 0 && (region == setup_.strip_region || region == setup_.strip_steel_region))
    bx *= setup_.strip_height / gap_;
  return {bx, by};
}

}  // namespace powbench::sim
