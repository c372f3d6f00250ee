#include "sim/solid/added_inertia.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/dot.h"

namespace powbench::sim {
namespace {

Vec3 times(const std::array<Vec3, 3>& m, const Vec3& a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}

}  // namespace

double own_step(const SolidMesh& mesh, const SolidCell& cell, const SolidMaterial& m) {
  // energy of a motion u: at most max(wave modulus, 2 mu) V (sum of gradients^2) |u|^2 / 2
  const auto x = corners_of(mesh, cell);
  const double volume = cell_volume(x, cell.is_hex()), node_mass = m.density * volume / cell.corners();
  const double stiffness =
      std::max(m.wave_modulus(), 2 * m.mu()) * gradient_square(x, cell.is_hex()) / volume;
  return 2 * std::sqrt(node_mass / stiffness);
}

AddedInertia::AddedInertia(const SolidMesh& mesh, const std::vector<SolidMaterial>& materials,
                           double wanted) {
  std::vector<double> own;
  for (const SolidCell& c : mesh.cells)
    own.push_back(own_step(mesh, c, materials[static_cast<std::size_t>(c.part)]));
  if (own.empty()) return;
  std::vector<double> sorted = own;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  if (!(wanted > 0 && wanted <= *middle))
    throw std::invalid_argument("scale_masses_to = " + std::to_string(wanted * 1e9) + " ns, must be in (0, " +
                                std::to_string(*middle * 1e9) +
                                "] ns, the median own step of the cells: scaling is for thin cells only");
  double mass = 0, added = 0;
  gains_.assign(own.size(), 1.0);
  for (std::size_t e = 0; e < own.size(); ++e) {
    const SolidCell& cell = mesh.cells[e];
    const double m = materials[static_cast<std::size_t>(cell.part)].density * cell_volume(mesh, cell);
    mass += m;
    if (!(own[e] < wanted)) continue;
    gains_[e] = wanted / own[e];
    const double lambda = gains_[e] * gains_[e] - 1;
    added += lambda * m;
    Cell c;
    c.part = cell.part;
    c.corners = cell.corners();
    c.inertia = lambda * m / c.corners;
    c.place = cell.nodes;
    cells_.push_back(c);
    nodes_.insert(nodes_.end(), cell.nodes.begin(), cell.nodes.begin() + c.corners);
  }
  share_ = added / mass;
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  for (Cell& c : cells_)
    for (std::size_t a = 0; a < static_cast<std::size_t>(c.corners); ++a)
      c.place[a] =
          static_cast<int>(std::lower_bound(nodes_.begin(), nodes_.end(), c.place[a]) - nodes_.begin());
  momentum_.assign(3 * nodes_.size(), 0.0);
  before_ = momentum_;
}

void AddedInertia::aim(Cell& c, const std::vector<Vec3>& at) const {
  const auto n = static_cast<std::size_t>(c.corners);
  Vec3 centre;
  for (std::size_t a = 0; a < n; ++a) centre += 1.0 / c.corners * at[static_cast<std::size_t>(c.place[a])];
  std::array<Vec3, 3> m{};
  for (std::size_t a = 0; a < n; ++a) {
    const Vec3 r = at[static_cast<std::size_t>(c.place[a])] - centre;
    c.arm[a] = r;
    for (int i = 0; i < 3; ++i) {
      m[static_cast<std::size_t>(i)] -= r[i] * r;
      m[static_cast<std::size_t>(i)][i] += dot(r, r);
    }
  }
  const Vec3 c0 = cross(m[1], m[2]), c1 = cross(m[2], m[0]), c2 = cross(m[0], m[1]);
  const double inverse = 1 / dot(m[0], c0);
  c.turn = {inverse * c0, inverse * c1, inverse * c2};  // m is symmetric, and so is its inverse
}

std::vector<double> AddedInertia::times(const std::vector<double>& a) const {
  std::vector<double> all(a.size(), 0.0);
  for (const Cell& c : cells_) {
    if (c.still) continue;
    const auto n = static_cast<std::size_t>(c.corners);
    std::array<Vec3, 8> v;
    Vec3 mean, moment;
    for (std::size_t k = 0; k < n; ++k) {
      const double* p = a.data() + 3 * c.place[k];
      v[k] = {p[0], p[1], p[2]};
      mean += v[k];
    }
    mean = 1.0 / c.corners * mean;
    for (std::size_t k = 0; k < n; ++k) {
      v[k] -= mean;
      moment += cross(c.arm[k], v[k]);
    }
    const Vec3 spin = sim::times(c.turn, moment);
    for (std::size_t k = 0; k < n; ++k) {
      const Vec3 p = c.inertia * (v[k] - cross(spin, c.arm[k]));
      for (int i = 0; i < 3; ++i)
        all[3 * static_cast<std::size_t>(c.place[k]) + static_cast<std::size_t>(i)] += p[i];
    }
  }
  return all;
}

std::vector<double> AddedInertia::solve(const std::vector<double>& diagonal,
                                        const std::vector<double>& b) const {
  constexpr double goal = 1e-11;
  constexpr int most = 500;
  std::vector<double> x(b.size(), 0.0), r(b), z(b.size()), p, weight(diagonal);
  for (const Cell& c : cells_)  // of the projection the diagonal is about 1 - 6 / (3 n)
    for (std::size_t k = 0; !c.still && k < static_cast<std::size_t>(c.corners); ++k)
      for (std::size_t i = 0; i < 3; ++i) {
        double& w = weight[3 * static_cast<std::size_t>(c.place[k]) + i];
        if (w > 0) w += c.inertia * (1 - 2.0 / c.corners);
      }
  const auto prepare = [&] {
    for (std::size_t k = 0; k < r.size(); ++k) z[k] = weight[k] > 0 ? r[k] / weight[k] : 0;
  };
  prepare();
  p = z;
  double size = dot(r, z);
  const double wanted = goal * goal * size;
  for (int k = 0; k < most && size > wanted; ++k) {
    std::vector<double> ap = times(p);
    for (std::size_t i = 0; i < ap.size(); ++i) ap[i] = diagonal[i] > 0 ? ap[i] + diagonal[i] * p[i] : 0;
    const double step = size / dot(p, ap);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] += step * p[i];
      r[i] -= step * ap[i];
    }
    prepare();
    const double next = dot(r, z), share = next / size;
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = z[i] + share * p[i];
    size = next;
    ++iterations_;
  }
  return x;
}

std::vector<double> AddedInertia::gather(const double* four) const {
  std::vector<double> all;
  for (const int n : nodes_) all.insert(all.end(), four + 4 * n, four + 4 * n + 3);
  return all;
}

void AddedInertia::correct(const std::vector<double>& diagonal, double drift, double* u, double* v) {
  const std::vector<double> lumped = gather(v);
  std::vector<double> gap = times(lumped);
  for (std::size_t k = 0; k < gap.size(); ++k) gap[k] = diagonal[k] > 0 ? momentum_[k] - gap[k] : 0;
  const std::vector<double> change = solve(diagonal, gap);
  std::vector<double> reached(lumped);
  for (std::size_t k = 0; k < reached.size(); ++k) reached[k] += change[k];
  before_ = momentum_;
  momentum_ = times(reached);
  // the change that this momentum takes, so that none is lost whatever the solve left over
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t at = 3 * k + i, to = 4 * static_cast<std::size_t>(nodes_[k]) + i;
      if (!(diagonal[at] > 0)) continue;
      const double by = (before_[at] - momentum_[at]) / diagonal[at];
      v[to] += by;
      u[to] += drift * by;
    }
}

double AddedInertia::kinetic(const double* v_before, const double* v_now) const {
  return 0.25 * (dot(gather(v_before), momentum_) + dot(gather(v_now), before_));
}

double AddedInertia::kinetic_of(int first, int last, const double* v) const {
  double sum = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    for (std::size_t i = 0; nodes_[k] >= first && nodes_[k] < last && i < 3; ++i)
      sum += 0.5 * momentum_[3 * k + i] * v[4 * static_cast<std::size_t>(nodes_[k]) + i];
  return sum;
}

void AddedInertia::rest(int first, int last) {
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    if (nodes_[k] >= first && nodes_[k] < last)
      std::fill_n(momentum_.begin() + 3 * static_cast<std::ptrdiff_t>(k), 3, 0.0);
}

}  // namespace powbench::sim
