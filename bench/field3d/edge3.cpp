#include "bench/field3d/edge3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/field3d/cholesky3.h"

namespace powbench::bench {
namespace {

constexpr double nu0 = 1 / (4e-7 * std::numbers::pi);

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

/// Edges of a brick: 0 .. 3 along x (by y, then z), 4 .. 7 along y (by x, then z), 8 .. 11 along z (by x, then y).
/// Faces: lower and upper normal to x, y, z. Flux through a face = sum of +- its four edges.
struct Curl {
  struct Term {
    int edge, sign;
  };
  Term face[6][4] = {{{4, 1}, {6, -1}, {8 + 2, 1}, {8 + 0, -1}}, {{5, 1}, {7, -1}, {8 + 3, 1}, {8 + 1, -1}},
                     {{2, 1}, {0, -1}, {8, 1}, {9, -1}},         {{3, 1}, {1, -1}, {10, 1}, {11, -1}},
                     {{5, 1}, {4, -1}, {0, 1}, {1, -1}},         {{7, 1}, {6, -1}, {2, 1}, {3, -1}}};
};

struct Brick {
  std::array<int, 12> edge;  ///< unknown, -1: zero
  std::array<double, 12> sign;
  std::array<double, 3> size;
  sim::Vec3 low;
  bool steel;
};

class EdgeEnergy {
 public:
  EdgeEnergy(const EdgeProblem& p)
      : p_(p),
        nx_(static_cast<int>(p.x.size())),
        ny_(static_cast<int>(p.y.size())),
        nz_(static_cast<int>(p.z.size())) {
    number();
    build_pattern();
    build_source();
  }

  int size() const { return count_; }
  const sim::SymmetricMatrix& pattern() const { return matrix_; }
  const std::vector<double>& source() const { return source_; }

  /// E(a); where asked its gradient and Hessian.
  double value(const std::vector<double>& a, std::vector<double>* gradient,
               sim::SymmetricMatrix* hessian) const {
    double energy = 0;
    if (gradient) gradient->assign(a.size(), 0);
    if (hessian) std::fill(hessian->value.begin(), hessian->value.end(), 0.0);
    for (std::size_t c = 0; c < bricks_.size(); ++c) {
      const Brick& b = bricks_[c];
      const auto flux = fluxes(b, a);
      std::array<double, 6> slope{};
      std::array<double, 36> bend{};
      energy += brick_energy(b, flux, slope, bend);
      if (gradient) spread(b, slope, *gradient);
      if (hessian) add_bend(c, bend, *hessian);
    }
    for (int i = 0; i < count_; ++i) {
      energy += 0.5 * mass_[at(i)] * a[at(i)] * a[at(i)];
      if (gradient) (*gradient)[at(i)] += mass_[at(i)] * a[at(i)];
      if (hessian) hessian->value[at(hessian->start[at(i)])] += mass_[at(i)];
    }
    return energy;
  }

  std::vector<double> faces_z(const std::vector<double>& a) const {
    std::vector<double> out(at((nx_ - 1) * (ny_ - 1) * nz_));
    const std::size_t layer = at((nx_ - 1) * (ny_ - 1));
    for (std::size_t c = 0; c < bricks_.size(); ++c) {
      const auto flux = fluxes(bricks_[c], a);
      out[c] = flux[4];
      out[c + layer] = flux[5];
    }
    return out;
  }

 private:
  void number();
  void build_pattern();
  void build_source();

  std::array<double, 6> fluxes(const Brick& b, const std::vector<double>& a) const {
    std::array<double, 6> out{};
    for (int f = 0; f < 6; ++f)
      for (const auto& [edge, sign] : curl_.face[f])
        if (b.edge[at(edge)] >= 0) out[at(f)] += sign * b.sign[at(edge)] * a[at(b.edge[at(edge)])];
    return out;
  }

  /// Adds what the brick's six fluxes weigh to its edges.
  void spread(const Brick& b, const std::array<double, 6>& weight, std::vector<double>& to) const {
    for (int f = 0; f < 6; ++f)
      for (const auto& [edge, sign] : curl_.face[f])
        if (b.edge[at(edge)] >= 0) to[at(b.edge[at(edge)])] += sign * b.sign[at(edge)] * weight[at(f)];
  }

  void add_bend(std::size_t brick, const std::array<double, 36>& bend, sim::SymmetricMatrix& h) const {
    const Brick& b = bricks_[brick];
    std::array<double, 144> local{};
    for (int f = 0; f < 6; ++f)
      for (int g = 0; g < 6; ++g)
        for (const auto& [e, s] : curl_.face[f])
          for (const auto& [d, t] : curl_.face[g]) local[at(e * 12 + d)] += s * t * bend[at(f * 6 + g)];
    const int* slot = slot_.data() + brick * 144;
    for (int e = 0; e < 12; ++e)
      for (int d = 0; d < 12; ++d)
        if (slot[e * 12 + d] >= 0)
          h.value[at(slot[e * 12 + d])] += b.sign[at(e)] * b.sign[at(d)] * local[at(e * 12 + d)];
  }

  /// Energy of a brick by its fluxes; B_x is linear along x between its two faces, and so on.
  double brick_energy(const Brick& b, const std::array<double, 6>& flux, std::array<double, 6>& slope,
                      std::array<double, 36>& bend) const {
    const double volume = b.size[0] * b.size[1] * b.size[2];
    const double point[2] = {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)};
    double energy = 0;
    for (int q = 0; q < 8; ++q) {
      std::array<double, 6> shape{};
      sim::Vec3 field{};
      for (std::size_t r = 0; r < 3; ++r) {
        const double t = point[(q >> r) & 1], area = volume / b.size[r];
        shape[2 * r] = (1 - t) / area;
        shape[2 * r + 1] = t / area;
        field[r] = shape[2 * r] * flux[2 * r] + shape[2 * r + 1] * flux[2 * r + 1];
      }
      const double w = volume / 8, square = field[0] * field[0] + field[1] * field[1] + field[2] * field[2];
      double nu = nu0, extra = 0;  // dH/dB = nu + extra B B^T
      if (b.steel) {
        const double size = std::sqrt(square);
        const auto s = p_.curve.at(size);
        nu = size > 0 ? s.h / size : s.dh_db;
        extra = square > 0 ? (s.dh_db - nu) / square : 0;
        energy += w * s.energy;
      } else {
        energy += w * 0.5 * nu0 * square;
      }
      for (std::size_t f = 0; f < 6; ++f) {
        slope[f] += w * nu * field[f / 2] * shape[f];
        for (std::size_t g = 0; g < 6; ++g)
          bend[f * 6 + g] +=
              w * shape[f] * shape[g] * ((f / 2 == g / 2 ? nu : 0) + extra * field[f / 2] * field[g / 2]);
      }
    }
    return energy;
  }

  const EdgeProblem& p_;
  int nx_, ny_, nz_, count_ = 0;
  Curl curl_;
  std::vector<Brick> bricks_;
  std::vector<double> mass_, source_;
  sim::SymmetricMatrix matrix_;
  std::vector<int> slot_;  ///< [brick][12 x 12]: place in the matrix, -1: none or in the other triangle
};

void EdgeEnergy::number() {
  // unknown and sign of each edge by direction and lattice place
  std::vector<int> unknown[3];
  std::vector<double> sign[3];
  const auto place = [&](int i, int j, int k) { return at((k * ny_ + j) * nx_ + i); };
  for (int d = 0; d < 3; ++d) {
    unknown[d].assign(at(nx_ * ny_ * nz_), -1);
    sign[d].assign(at(nx_ * ny_ * nz_), 1);
    for (int k = 0; k < nz_ - (d == 2); ++k)
      for (int j = 0; j < ny_ - (d == 1); ++j)
        for (int i = 0; i < nx_ - (d == 0); ++i) {
          const bool wall =
              (d != 0 && i == nx_ - 1) || (d != 1 && (j == 0 || j == ny_ - 1)) || (d != 2 && k == nz_ - 1);
          const int mirrored = ny_ - 1 - j - (d == 1);
          const bool tied = d != 0 && i == 0 && j < mirrored;
          if (!wall && !tied) unknown[d][place(i, j, k)] = count_++;
        }
  }
  for (int d = 1; d < 3; ++d)
    for (int k = 0; k < nz_ - (d == 2); ++k)
      for (int j = 0; j < ny_ - (d == 1); ++j) {
        const int mirrored = ny_ - 1 - j - (d == 1);
        if (j >= mirrored) continue;
        unknown[d][place(0, j, k)] = unknown[d][place(0, mirrored, k)];
        sign[d][place(0, j, k)] = d == 1 ? -1 : 1;
      }
  mass_.assign(at(count_), 0);
  constexpr double share = 1e-6, length = 0.1;
  for (int k = 0; k + 1 < nz_; ++k)
    for (int j = 0; j + 1 < ny_; ++j)
      for (int i = 0; i + 1 < nx_; ++i) {
        Brick b;
        b.low = {p_.x[at(i)], p_.y[at(j)], p_.z[at(k)]};
        b.size = {p_.x[at(i + 1)] - b.low[0], p_.y[at(j + 1)] - b.low[1], p_.z[at(k + 1)] - b.low[2]};
        b.steel = p_.steel({b.low[0] + b.size[0] / 2, b.low[1] + b.size[1] / 2, b.low[2] + b.size[2] / 2});
        for (int e = 0; e < 12; ++e) {
          const int d = e / 4, first = e % 2, second = e / 2 % 2;
          const std::size_t n = place(i + (d == 0 ? 0 : first),
                                      j + (d == 0   ? first
                                           : d == 1 ? 0
                                                    : second),
                                      k + (d == 2 ? 0 : second));
          b.edge[at(e)] = unknown[d][n];
          b.sign[at(e)] = sign[d][n];
          if (unknown[d][n] >= 0)
            mass_[at(unknown[d][n])] += share * nu0 / (length * length) * b.size[0] * b.size[1] * b.size[2] /
                                        (4 * b.size[at(d)] * b.size[at(d)]);
        }
        bricks_.push_back(b);
      }
}

void EdgeEnergy::build_pattern() {
  std::vector<std::vector<int>> rows(at(count_));
  for (const auto& b : bricks_)
    for (const int e : b.edge)
      for (const int d : b.edge)
        if (e >= 0 && d >= e) rows[at(e)].push_back(d);
  matrix_.start.push_back(0);
  for (auto& r : rows) {
    std::sort(r.begin(), r.end());
    r.erase(std::unique(r.begin(), r.end()), r.end());
    matrix_.row.insert(matrix_.row.end(), r.begin(), r.end());
    matrix_.start.push_back(static_cast<int>(matrix_.row.size()));
  }
  matrix_.value.assign(matrix_.row.size(), 0);
  slot_.assign(bricks_.size() * 144, -1);
  for (std::size_t c = 0; c < bricks_.size(); ++c)
    for (int e = 0; e < 12; ++e)
      for (int d = 0; d < 12; ++d) {
        const int column = bricks_[c].edge[at(e)], row = bricks_[c].edge[at(d)];
        if (column < 0 || row < column) continue;
        const auto first = matrix_.row.begin() + matrix_.start[at(column)];
        const auto last = matrix_.row.begin() + matrix_.start[at(column) + 1];
        slot_[c * 144 + at(e * 12 + d)] =
            static_cast<int>(std::lower_bound(first, last, row) - matrix_.row.begin());
      }
}

void EdgeEnergy::build_source() {
  source_.assign(at(count_), 0);
  const double point[3] = {0.5 - 0.5 * std::sqrt(0.6), 0.5, 0.5 + 0.5 * std::sqrt(0.6)};
  const double part[3] = {5. / 18, 8. / 18, 5. / 18};
  for (const auto& b : bricks_) {
    std::array<double, 6> weight{};
    for (int q = 0; q < 27; ++q) {
      const int k[3] = {q % 3, q / 3 % 3, q / 9};
      const sim::Vec3 t = p_.source({b.low[0] + point[k[0]] * b.size[0], b.low[1] + point[k[1]] * b.size[1],
                                     b.low[2] + point[k[2]] * b.size[2]});
      for (std::size_t r = 0; r < 3; ++r) {
        const double w = part[k[0]] * part[k[1]] * part[k[2]] * b.size[r] * t[r];
        weight[2 * r] += w * (1 - point[k[r]]);
        weight[2 * r + 1] += w * point[k[r]];
      }
    }
    spread(b, weight, source_);
  }
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace

EdgeSolution solve_edges(const EdgeProblem& p, double current) {
  const EdgeEnergy energy(p);
  sim::SymmetricMatrix hessian = energy.pattern();
  sim::Cholesky3 factor(hessian);
  EdgeSolution out;
  out.unknowns = energy.size();
  std::vector<double> a(at(energy.size()), 0), gradient;
  for (; out.iterations < 60 && !out.converged; ++out.iterations) {
    const double stored = energy.value(a, &gradient, &hessian);
    const double from = stored - current * dot(energy.source(), a);
    for (std::size_t k = 0; k < a.size(); ++k) gradient[k] -= current * energy.source()[k];
    if (!factor.factor(hessian)) break;
    const auto step = factor.solve(gradient);
    const double decrement = dot(step, gradient);
    out.converged = decrement <= 1e-11 * stored;
    std::vector<double> next(a.size());
    for (double share = 1; share > 1e-6; share /= 2) {
      for (std::size_t k = 0; k < a.size(); ++k) next[k] = a[k] - share * step[k];
      const double to = energy.value(next, nullptr, nullptr) - current * dot(energy.source(), next);
      if (out.converged || to <= from - 0.1 * share * decrement) break;
    }
    a = std::move(next);
  }
  out.psi = p.copies * dot(energy.source(), a);
  out.face_z = energy.faces_z(a);
  return out;
}

double edge_average(const EdgeProblem& p, const EdgeSolution& s, double x0, double x1, double y0, double y1,
                    double z) {
  constexpr double round_off = 1e-9;
  const auto above = std::upper_bound(p.z.begin() + 1, p.z.end() - 1, z);
  const std::size_t k = static_cast<std::size_t>(above - p.z.begin()) - 1;
  const double t = (z - p.z[k]) / (p.z[k + 1] - p.z[k]);
  const std::size_t columns = p.x.size() - 1, layer = columns * (p.y.size() - 1);
  double flux = 0;
  for (std::size_t j = 0; j + 1 < p.y.size(); ++j)
    for (std::size_t i = 0; i < columns; ++i)
      if (p.x[i] > x0 - round_off && p.x[i + 1] < x1 + round_off && p.y[j] > y0 - round_off &&
          p.y[j + 1] < y1 + round_off) {
        const std::size_t f = k * layer + j * columns + i;
        flux += (1 - t) * s.face_z[f] + t * s.face_z[f + layer];
      }
  return flux / ((x1 - x0) * (y1 - y0));
}

}  // namespace powbench::bench
