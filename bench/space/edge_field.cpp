#include "bench/space/edge_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "bench/space/edge_space.h"
#include "sim/magnetics/space/cholesky.h"

namespace powbench::bench {
namespace {

constexpr double nu0 = 1 / (4e-7 * std::numbers::pi);

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

/// Gauss points of a brick, three along each edge: place in [0, 1]^3 and share of the volume.
struct GaussPoint {
  sim::Vec3 t;
  double share;
};

std::vector<GaussPoint> gauss_points() {
  const double point[3] = {0.5 - 0.5 * std::sqrt(0.6), 0.5, 0.5 + 0.5 * std::sqrt(0.6)};
  constexpr double part[3] = {5. / 18, 8. / 18, 5. / 18};
  std::vector<GaussPoint> out;
  for (int q = 0; q < 27; ++q) {
    const int k[3] = {q % 3, q / 3 % 3, q / 9};
    out.push_back({{point[k[0]], point[k[1]], point[k[2]]}, part[k[0]] * part[k[1]] * part[k[2]]});
  }
  return out;
}

double volume(const EdgeSpace::Brick& b) {
  return b.size[0] * b.size[1] * b.size[2];
}

}  // namespace

struct EdgeField::Impl {
  EdgeProblem p;
  EdgeSpace space;
  std::vector<GaussPoint> points = gauss_points();
  std::vector<int> slot;
  sim::space::SymmetricMatrix linear, hessian;  ///< of air and gauge; with the steel
  std::vector<double> source;                   ///< psi = source . a of this part
  std::vector<std::size_t> steel;               ///< bricks

  explicit Impl(EdgeProblem problem) : p(std::move(problem)), space(p.order, p.x, p.y, p.z) {
    linear = space.pattern(slot);
    source.assign(at(space.count()), 0);
    for (std::size_t k = 0; k < space.bricks().size(); ++k) {
      const auto& b = space.bricks()[k];
      if (p.steel(place(b, {0.5, 0.5, 0.5}))) steel.push_back(k);
      add_source(b);
      add_gauge(k);
    }
    add_air();
    hessian = linear;
  }

  static sim::Vec3 place(const EdgeSpace::Brick& b, const sim::Vec3& t) {
    return {b.low[0] + t[0] * b.size[0], b.low[1] + t[1] * b.size[1], b.low[2] + t[2] * b.size[2]};
  }

  void add_source(const EdgeSpace::Brick& b) {
    std::vector<sim::Vec3> curls;
    for (const auto& q : points) {
      const sim::Vec3 t = p.source(place(b, q.t));
      if (t == sim::Vec3{}) continue;
      space.curls(b.size, q.t, curls);
      for (std::size_t n = 0; n < curls.size(); ++n)
        if (b.unknown[n] >= 0)
          source[at(b.unknown[n])] += q.share * volume(b) * b.sign[n] *
                                      (t[0] * curls[n][0] + t[1] * curls[n][1] + t[2] * curls[n][2]);
    }
  }

  void add_gauge(std::size_t brick) {
    constexpr double share = 1e-6, length = 0.1;
    const auto& b = space.bricks()[brick];
    const auto& f = space.functions();
    for (std::size_t n = 0; n < f.size(); ++n) {
      const double along = b.size[at(f[n].component)];
      if (b.unknown[n] >= 0 && f[n].lowest())
        linear.value[at(slot[(brick * f.size() + n) * f.size() + n])] +=
            share * nu0 / (length * length) * volume(b) / (4 * along * along);
    }
  }

  void add_air() {
    auto next = steel.begin();
    for (std::size_t k = 0; k < space.bricks().size(); ++k) {
      if (next != steel.end() && *next == k) {
        ++next;
        continue;
      }
      const auto& b = space.bricks()[k];
      std::vector<sim::Vec3> curls;
      std::vector<double> block(space.functions().size() * space.functions().size(), 0);
      for (const auto& q : points) {
        space.curls(b.size, q.t, curls);
        add_block(curls, q.share * volume(b), nu0, 0, {}, block);
      }
      spread(k, block, linear);
    }
  }

  /// Adds w (nu + extra B B^T) between the curls to the block.
  static void add_block(const std::vector<sim::Vec3>& c, double w, double nu, double extra,
                        const sim::Vec3& field, std::vector<double>& block) {
    for (std::size_t n = 0; n < c.size(); ++n) {
      const double along = extra * (field[0] * c[n][0] + field[1] * c[n][1] + field[2] * c[n][2]);
      sim::Vec3 v;
      for (std::size_t r = 0; r < 3; ++r) v[r] = w * (nu * c[n][r] + along * field[r]);
      for (std::size_t m = 0; m < c.size(); ++m)
        block[n * c.size() + m] += v[0] * c[m][0] + v[1] * c[m][1] + v[2] * c[m][2];
    }
  }

  void spread(std::size_t brick, const std::vector<double>& block, sim::space::SymmetricMatrix& to) const {
    const auto& b = space.bricks()[brick];
    const std::size_t size = b.unknown.size();
    const int* places = slot.data() + brick * size * size;
    for (std::size_t n = 0; n < size; ++n)
      for (std::size_t m = 0; m < size; ++m)
        if (const int s = places[n * size + m]; s >= 0)
          to.value[at(s)] += b.sign[n] * b.sign[m] * block[n * size + m];
  }

  /// Zero; for order 2 the solution of order 1 on the same bricks, whose functions come in the same sequence.
  std::vector<double> start(double current) const {
    std::vector<double> a(at(space.count()), 0);
    if (p.order == 1) return a;
    EdgeProblem lower = p;
    lower.order = 1;
    EdgeField field(std::move(lower));
    const auto first = field.solve(current).a;
    for (std::size_t k = 0; k < space.bricks().size(); ++k) {
      const auto& to = space.bricks()[k];
      const auto& from = field.impl_->space.bricks()[k];
      for (std::size_t n = 0, l = 0; n < to.unknown.size(); ++n)
        if (space.functions()[n].lowest() && from.unknown[l++] >= 0)
          a[at(to.unknown[n])] = first[at(from.unknown[l - 1])];
    }
    return a;
  }

  /// E(a); where wanted its gradient and Hessian too.
  double energy(const std::vector<double>& a, std::vector<double>* gradient, bool with_hessian) {
    std::vector<double> slope;
    linear.multiply(a, slope);
    double sum = 0.5 * dot(a, slope);
    if (with_hessian) hessian.value = linear.value;
    std::vector<sim::Vec3> curls;
    std::vector<double> block;
    for (const auto k : steel) {
      const auto& b = space.bricks()[k];
      block.assign(b.unknown.size() * b.unknown.size(), 0);
      for (const auto& q : points) {
        space.curls(b.size, q.t, curls);
        const auto field = space.field(b, curls, a);
        const double square = field[0] * field[0] + field[1] * field[1] + field[2] * field[2];
        const double size = std::sqrt(square), w = q.share * volume(b);
        const auto s = p.curve.at(size);
        sum += w * s.energy;
        if (!gradient) continue;
        const double nu = size > 0 ? s.h / size : s.dh_db;
        for (std::size_t n = 0; n < curls.size(); ++n)
          if (b.unknown[n] >= 0)
            slope[at(b.unknown[n])] +=
                w * nu * b.sign[n] *
                (field[0] * curls[n][0] + field[1] * curls[n][1] + field[2] * curls[n][2]);
        if (with_hessian) add_block(curls, w, nu, square > 0 ? (s.dh_db - nu) / square : 0, field, block);
      }
      if (with_hessian) spread(k, block, hessian);
    }
    if (gradient) *gradient = std::move(slope);
    return sum;
  }
};

EdgeField::EdgeField(EdgeProblem p) : impl_(std::make_unique<Impl>(std::move(p))) {}
EdgeField::~EdgeField() = default;

int EdgeField::unknowns() const {
  return impl_->space.count();
}

EdgeSolution EdgeField::solve(double current) {
  Impl& m = *impl_;
  sim::space::Cholesky factor(m.hessian);
  EdgeSolution out;
  out.a = m.start(current);
  auto& a = out.a;
  std::vector<double> gradient, next(a.size());
  for (; out.iterations < 60 && !out.converged; ++out.iterations) {
    const double stored = m.energy(a, &gradient, true);
    const double from = stored - current * dot(m.source, a);
    for (std::size_t k = 0; k < a.size(); ++k) gradient[k] -= current * m.source[k];
    if (!factor.factor(m.hessian)) break;
    const auto step = factor.solve(gradient);
    const double decrement = dot(step, gradient);
    out.converged = decrement <= 1e-11 * stored;
    for (double share = 1; share > 1e-6; share /= 2) {
      for (std::size_t k = 0; k < a.size(); ++k) next[k] = a[k] - share * step[k];
      if (out.converged) break;
      const double to = m.energy(next, nullptr, false) - current * dot(m.source, next);
      if (to <= from - 0.1 * share * decrement) break;
    }
    std::swap(a, next);
  }
  out.psi = m.p.copies * dot(m.source, a);
  return out;
}

double EdgeField::average(const EdgeSolution& s, double x0, double x1, double y0, double y1, double z) const {
  constexpr double round_off = 1e-9;
  const EdgeSpace& space = impl_->space;
  std::vector<sim::Vec3> curls;
  double flux = 0;
  for (const auto& b : space.bricks()) {
    const bool inside = b.low[0] > x0 - round_off && b.low[0] + b.size[0] < x1 + round_off &&
                        b.low[1] > y0 - round_off && b.low[1] + b.size[1] < y1 + round_off && b.low[2] <= z &&
                        z < b.low[2] + b.size[2];
    if (!inside) continue;
    for (const auto& q : impl_->points) {
      space.curls(b.size, {q.t[0], q.t[1], (z - b.low[2]) / b.size[2]}, curls);
      flux += q.share * b.size[0] * b.size[1] * space.field(b, curls, s.a)[2];
    }
  }
  return flux / ((x1 - x0) * (y1 - y0));
}

}  // namespace powbench::bench
