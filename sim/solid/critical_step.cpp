#include <algorithm>
#include <cmath>

#include "sim/dot.h"
#include "sim/solid/explicit_solid.h"

namespace powbench::sim {
namespace {

/// Largest eigenvalue of a symmetric tridiagonal matrix, by bisection on the number of sign changes.
double largest_eigenvalue(const std::vector<double>& d, const std::vector<double>& e) {
  double lo = 0, hi = 0;
  for (std::size_t i = 0; i < d.size(); ++i) {
    const double left = i > 0 ? std::fabs(e[i - 1]) : 0, right = i + 1 < d.size() ? std::fabs(e[i]) : 0;
    hi = std::max(hi, d[i] + left + right);
  }
  for (int k = 0; k < 200 && hi - lo > 1e-14 * hi; ++k) {
    const double x = 0.5 * (lo + hi);
    int below = 0;
    double q = 1;
    for (std::size_t i = 0; i < d.size(); ++i) {
      q = d[i] - x - (i > 0 ? e[i - 1] * e[i - 1] / (q != 0 ? q : 1e-300) : 0);
      below += q < 0;
    }
    (below == static_cast<int>(d.size()) ? hi : lo) = x;
  }
  return hi;
}

/// A start vector that favours no direction and is the same everywhere.
double noise(std::size_t k) {
  auto z = (static_cast<std::uint64_t>(k) + 1) * 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return static_cast<double>(z >> 11) / 9007199254740992.0 - 0.5;
}

/// The masses in units of the lumped ones: 1 where no inertia is added.
class ScaledMasses {
 public:
  ScaledMasses(const AddedInertia& inertia, const std::vector<double>& root)
      : inertia_(inertia), root_(root) {
    for (const int n : inertia.nodes())
      for (std::size_t i = 0; i < 3; ++i) {
        const double r = root[4 * static_cast<std::size_t>(n) + i];
        mass_.push_back(r > 0 ? 1 / (r * r) : 0);
      }
  }

  std::vector<double> times(const std::vector<double>& q) const {
    std::vector<double> all = q, part = inertia_.gather(q.data());
    each([&](std::size_t at, std::size_t k) { part[k] *= root_[at]; });
    part = inertia_.times(part);
    each([&](std::size_t at, std::size_t k) { all[at] += root_[at] * part[k]; });
    return all;
  }

  std::vector<double> solve(const std::vector<double>& b) const {
    std::vector<double> all = b, part = inertia_.gather(b.data());
    each([&](std::size_t at, std::size_t k) { part[k] = root_[at] > 0 ? part[k] / root_[at] : 0; });
    part = inertia_.solve(mass_, part);
    each([&](std::size_t at, std::size_t k) { all[at] = root_[at] > 0 ? part[k] / root_[at] : 0; });
    return all;
  }

 private:
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::size_t n = 0; n < inertia_.nodes().size(); ++n)
      for (std::size_t i = 0; i < 3; ++i)
        visit(4 * static_cast<std::size_t>(inertia_.nodes()[n]) + i, 3 * n + i);
  }

  const AddedInertia& inertia_;
  const std::vector<double>& root_;
  std::vector<double> mass_;
};

}  // namespace

double cell_critical_step(const SolidMesh& mesh, const std::vector<SolidMaterial>& materials,
                          const std::vector<double>& inverse_mass, const std::vector<double>& added,
                          const AddedInertia& inertia) {
  std::vector<SolidMaterial> linear = materials;
  for (auto& m : linear) {
    if (m.law() == SolidLaw::plastic) m.hourglass *= 0.1;
    m.yield = std::numeric_limits<double>::infinity();
    m.small_displacement = true;
  }
  CellBatches cells(mesh, linear, false);
  const std::size_t size = inverse_mass.size();
  std::vector<double> q(size), last(size, 0.0), u(size), w(size), root(size);
  for (std::size_t k = 0; k < size; ++k) {
    root[k] = std::sqrt(inverse_mass[k]);
    q[k] = root[k] > 0 ? noise(k) : 0;
  }
  // in u = M^-1/2 q the masses are S = 1 + M^-1/2 (M' - M) M^-1/2; p = S q, and vectors are orthonormal in S
  const ScaledMasses scaled(inertia, root);
  std::vector<double> diagonal, beside, p = scaled.times(q);
  double beta = std::sqrt(dot(q, p)), previous = 0, found = 0;
  if (!(beta > 0)) return 1e300;  // everything is fixed
  constexpr int most = 120;
  for (int step = 0; step < most && beta > 0; ++step) {
    for (std::size_t k = 0; k < size; ++k) {
      q[k] /= beta;
      p[k] /= beta;
      u[k] = root[k] * q[k];
    }
    for (int b = 0; b < cells.count(); ++b) cells.compute(b, u.data(), u.data(), 0);
    double alpha = 0;
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      const Vec3 f = cells.node_force(static_cast<int>(n));
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t k = 4 * n + i;
        const double force = i < 3 ? -f[static_cast<int>(i)] + added[n] * u[k] : 0;
        w[k] = root[k] * force - (step > 0 ? beside.back() * last[k] : 0);
        alpha += w[k] * q[k];
      }
    }
    for (std::size_t k = 0; k < size; ++k) w[k] -= alpha * p[k];
    diagonal.push_back(alpha);
    last = p;
    p = w;
    q = scaled.solve(w);
    beta = std::sqrt(dot(q, p));
    if (step % 10 == 9) {
      found = largest_eigenvalue(diagonal, beside);
      if (found - previous < 1e-7 * found) break;
      previous = found;
    }
    beside.push_back(beta);
    if (beta < 1e-12 * found) break;
  }
  found = std::max(found, largest_eigenvalue(diagonal, beside));
  return 2 / std::sqrt(found);
}

double ExplicitSolid::critical_step() const {
  const std::size_t nodes = cells_.mesh().nodes.size();
  std::vector<double> added(nodes, 0.0);
  for (const auto& plane : planes_)
    for (std::size_t k = 0; k < plane.nodes.size(); ++k)
      added[static_cast<std::size_t>(plane.nodes[k])] += plane.stiffness[k];
  if (contact_) {
    const auto penalty = contact_->stiffness();
    for (std::size_t n = 0; n < nodes; ++n) added[n] += penalty[n];
  }
  std::vector<double> damping(nodes, 0.0);
  for (const auto& plane : planes_)
    for (std::size_t k = 0; k < plane.damping.size(); ++k)
      damping[static_cast<std::size_t>(plane.nodes[k])] += plane.damping[k];
  if (contact_) {
    const auto dashpots = contact_->damping();
    for (std::size_t n = 0; n < nodes; ++n) damping[n] += dashpots[n];
  }
  std::vector<SolidMaterial> materials;
  for (std::size_t p = 0; p < cells_.mesh().parts.size(); ++p)
    materials.push_back(cells_.material(static_cast<int>(p)));
  AddedInertia inertia = inertia_;
  inertia.aim(cells_.mesh().nodes, u_.data(), v_.data(), 0, [](int) { return false; });
  double limit = cell_critical_step(cells_.mesh(), materials, inverse_mass_, added, inertia);
  if (std::all_of(damping.begin(), damping.end(), [](double c) { return c == 0; })) return limit;
  // a damping force half a step late takes w^2 dt^2 + 2 c dt / m <= 4: like a stiffness 2 c / dt at that step
  for (int k = 0; k < 3; ++k) {
    std::vector<double> stiff = added;
    for (std::size_t n = 0; n < nodes; ++n) stiff[n] += 2 * damping[n] / limit;
    limit = cell_critical_step(cells_.mesh(), materials, inverse_mass_, stiff, inertia);
  }
  return limit;
}

}  // namespace powbench::sim
