#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/solid/cell_batches.h"
#include "sim/solid/flush_denormals.h"

/// What the batches compute: forces in each step, energies and stresses when asked.

namespace powbench::sim {
namespace {

constexpr std::size_t lanes = block_cells;

using Tensor = std::array<std::array<double, 3>, 3>;

double determinant(const Tensor& f) {
  return f[0][0] * (f[1][1] * f[2][2] - f[1][2] * f[2][1]) -
         f[0][1] * (f[1][0] * f[2][2] - f[1][2] * f[2][0]) +
         f[0][2] * (f[1][0] * f[2][1] - f[1][1] * f[2][0]);
}

/// J - 1 without cancellation.
double growth(const Tensor& h) {
  const double second = h[0][0] * h[1][1] - h[0][1] * h[1][0] + h[1][1] * h[2][2] - h[1][2] * h[2][1] +
                        h[2][2] * h[0][0] - h[2][0] * h[0][2];
  return h[0][0] + h[1][1] + h[2][2] + second + determinant(h);
}

/// Stored energy a volume, J/m3; the neo-Hookean mu/2 (F:F - 3 - 2 ln J) written in the displacement gradient.
double energy_density(const Tensor& h, const SolidMaterial& m) {
  const double trace = h[0][0] + h[1][1] + h[2][2];
  double square = 0, symmetric = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      square += h[i][j] * h[i][j];
      symmetric += 0.25 * (h[i][j] + h[j][i]) * (h[i][j] + h[j][i]);
    }
  if (m.law() == SolidLaw::linear) return 0.5 * m.lambda() * trace * trace + m.mu() * symmetric;
  const double g = growth(h);
  return 0.5 * m.mu() * (2 * trace + square - 2 * std::log1p(g)) + 0.5 * m.lambda() * g * g;
}

/// Cauchy stress.
std::array<double, 6> cauchy(const Tensor& h, const SolidMaterial& m) {
  Tensor s{};
  if (m.law() == SolidLaw::linear) {
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) s[i][j] = m.mu() * (h[i][j] + h[j][i]);
    for (std::size_t i = 0; i < 3; ++i) s[i][i] += m.lambda() * (h[0][0] + h[1][1] + h[2][2]);
  } else {  // mu (F F^T - I) / J + lambda (J - 1) I
    const double g = growth(h);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        double b = h[i][j] + h[j][i];
        for (std::size_t k = 0; k < 3; ++k) b += h[i][k] * h[j][k];
        s[i][j] = m.mu() * b / (1 + g);
      }
      s[i][i] += m.lambda() * g;
    }
  }
  return {s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[0][2]};
}

}  // namespace

double von_mises(const CellStress& c) {
  const auto& s = c.stress;
  const double a = s[0] - s[1], b = s[1] - s[2], d = s[2] - s[0];
  return std::sqrt(0.5 * (a * a + b * b + d * d) + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

template <class Real>
double CellBatches::elastic(Batch& b, const double* u) {
  thread_local std::vector<Real> local;
  local.resize(4 * (b.nodes.size() + 1));
  // in float only differences within the batch count, so its first node's displacement is taken off in double
  double base[4] = {0, 0, 0, 0};
  if constexpr (sizeof(Real) == 4) std::copy_n(u + 4 * static_cast<std::size_t>(b.nodes[0]), 4, base);
  Real* to = local.data();
  for (const int n : b.nodes) {
    const double* from = u + 4 * static_cast<std::size_t>(n);
    for (int i = 0; i < 4; ++i) *to++ = static_cast<Real>(from[i] - base[i]);
  }
  std::fill_n(to, 4, Real(0));
  ElasticBatch<Real> work;
  work.nodes = b.corners.data();
  work.u = local.data();
  work.blocks = static_cast<int>((b.cells.size() + lanes - 1) / lanes);
  work.lambda = static_cast<Real>(material(b.part).lambda());
  work.mu = static_cast<Real>(material(b.part).mu());
  const bool linear = material(b.part).law() == SolidLaw::linear;
  if constexpr (sizeof(Real) == 4) {
    work.shape = b.float_shape.data();
    work.f = float_forces_.data() + b.force_place;
    std::fill_n(work.f, local.size(), Real(0));
    const FlushDenormals in_here;
    return static_cast<double>(
        (b.kind == Kind::brick ? kernel_->brick_float : kernel_->hex_float)(work, linear));
  } else {
    work.shape = b.shape.data();
    work.f = forces_.data() + b.force_place;
    std::fill_n(work.f, local.size(), Real(0));
    const FlushDenormals in_here;
    return (b.kind == Kind::brick ? kernel_->brick
            : b.kind == Kind::hex ? kernel_->hex
                                  : kernel_->tet)(work, linear);
  }
}

double CellBatches::plastic(Batch& b, const double* u, const double* v, double dt) {
  thread_local std::vector<double> place, speed;
  place.assign(4 * (b.nodes.size() + 1), 0.0);
  speed.assign(4 * (b.nodes.size() + 1), 0.0);
  for (std::size_t k = 0; k < b.nodes.size(); ++k) {
    const auto n = static_cast<std::size_t>(b.nodes[k]);
    for (int i = 0; i < 3; ++i) {
      place[4 * k + static_cast<std::size_t>(i)] = mesh_.nodes[n][i] + u[4 * n + static_cast<std::size_t>(i)];
      speed[4 * k + static_cast<std::size_t>(i)] = v[4 * n + static_cast<std::size_t>(i)];
    }
  }
  const SolidMaterial& m = material(b.part);
  PlasticBatch work;
  work.nodes = b.corners.data();
  work.state = b.state.data();
  work.x = place.data();
  work.v = speed.data();
  work.f = forces_.data() + b.force_place;
  work.blocks = static_cast<int>((b.cells.size() + lanes - 1) / lanes);
  work.lambda = m.lambda();
  work.mu = m.mu();
  work.yield = m.yield;
  work.hardening = m.hardening;
  work.hourglass = 0.1 * m.hourglass * m.young;
  work.dt = dt;
  std::fill_n(work.f, place.size(), 0.0);
  const auto forces = b.kind == Kind::plastic ? kernel_->plastic : kernel_->plastic_tet;
  const double smallest = [&] {
    const FlushDenormals in_here;
    return forces(work);
  }();
  b.stored += work.stored;
  b.plastic += work.plastic_work;
  b.hourglass += work.hourglass_work;
  return smallest;
}

int CellBatches::compute(int batch, const double* u, const double* v, double dt) {
  Batch& b = batches_[static_cast<std::size_t>(batch)];
  const double smallest = flows(b.kind) ? plastic(b, u, v, dt)
                          : in_float_   ? elastic<float>(b, u)
                                        : elastic<double>(b, u);
  if (smallest > 0) return -1;  // NaN is not > 0
  return material(b.part).law() == SolidLaw::linear ? -1 : inverted(b, u);
}

int CellBatches::inverted(const Batch& b, const double* u) const {
  SolidMesh bent;
  bent.nodes.resize(mesh_.nodes.size());
  for (const int n : b.nodes) {
    const auto k = static_cast<std::size_t>(n);
    bent.nodes[k] = mesh_.nodes[k] + Vec3{u[4 * k], u[4 * k + 1], u[4 * k + 2]};
  }
  for (const int e : b.cells)
    if (!(cell_volume(bent, mesh_.cells[static_cast<std::size_t>(e)]) > 0)) return e;
  return b.cells[0];
}

namespace {

struct CellState {
  Tensor gradient{};
  double volume = 0, hourglass = 0;  ///< m3, J
};

CellState state_of(const SolidMesh& mesh, const SolidCell& cell, const SolidMaterial& m,
                   const std::vector<double>& u) {
  CellState state;
  const auto corners = static_cast<std::size_t>(cell.corners());
  std::array<Vec3, 8> x{}, moved{}, b{};
  for (std::size_t a = 0; a < corners; ++a) {
    const auto n = static_cast<std::size_t>(cell.nodes[a]);
    x[a] = mesh.nodes[n] - mesh.nodes[static_cast<std::size_t>(cell.nodes[0])];
    moved[a] = {u[4 * n], u[4 * n + 1], u[4 * n + 2]};
  }
  HexShape s;
  if (cell.is_hex()) {
    s = hex_shape(x);
    b = hex_gradient(s);
    state.volume = s.volume;
  } else {
    const double six = dot(x[1], cross(x[2], x[3]));
    state.volume = six / 6;
    b[1] = 1.0 / 6 * cross(x[2], x[3]);
    b[2] = 1.0 / 6 * cross(x[3], x[1]);
    b[3] = 1.0 / 6 * cross(x[1], x[2]);
    b[0] = -(b[1] + b[2] + b[3]);
  }
  for (std::size_t a = 0; a < corners; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        state.gradient[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] +=
            (moved[a][i] - moved[0][i]) * b[a][j] / state.volume;
  if (!cell.is_hex()) return state;
  const Vec3 base = moved[0];  // the modes see no translation, but rounding does
  for (Vec3& d : moved) d -= base;
  const auto w = hex_modes(moved);
  const auto k = hourglass_stiffness(s, m);
  for (std::size_t h = 0; h < 4; ++h)
    for (int i = 0; i < 3; ++i) {
      double q = w[3 + h][i];
      for (int j = 0; j < 3; ++j)
        q -= s.hourglass[h][j] * state.gradient[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      state.hourglass += 0.5 * k[3 * h + static_cast<std::size_t>(i)] * q * q;
    }
  return state;
}

}  // namespace

CellEnergies CellBatches::energies(int part, const std::vector<double>& u) const {
  CellEnergies sum;
  for (const Batch& b : batches_) {
    if (b.part != part) continue;
    sum.plastic += b.plastic;
    sum.strain += b.stored - b.plastic;
    sum.hourglass += b.hourglass;
    if (flows(b.kind)) continue;
    for (const int e : b.cells) {
      const CellState s = state_of(mesh_, mesh_.cells[static_cast<std::size_t>(e)], material(part), u);
      sum.strain += s.volume * energy_density(s.gradient, material(part));
      sum.hourglass += s.hourglass;
    }
  }
  return sum;
}

std::vector<CellStress> CellBatches::stresses(const std::vector<double>& u) const {
  std::vector<CellStress> all(mesh_.cells.size());
  for (const Batch& b : batches_)
    for (std::size_t k = 0; k < b.cells.size(); ++k) {
      CellStress& c = all[static_cast<std::size_t>(b.cells[k])];
      if (flows(b.kind)) {
        const auto number = [&](std::size_t i) {
          return b.state[(k / lanes * numbers_of(b.kind) + i) * lanes + k % lanes];
        };
        for (std::size_t i = 0; i < 6; ++i) c.stress[i] = number(i);
        c.plastic = number(6);
      } else {
        const SolidCell& cell = mesh_.cells[static_cast<std::size_t>(b.cells[k])];
        c.stress = cauchy(state_of(mesh_, cell, material(b.part), u).gradient, material(b.part));
      }
    }
  return all;
}

double CellBatches::plastic_transit(const double* u, const std::vector<double>& gains) const {
  double least = 1e300;
  for (const Batch& b : batches_) {
    if (!flows(b.kind)) continue;
    const double modulus = material(b.part).wave_modulus();
    for (const int e : b.cells) {
      const SolidCell& cell = mesh_.cells[static_cast<std::size_t>(e)];
      std::array<Vec3, 8> x{};
      double mass = 0;
      for (std::size_t a = 0; a < corners_of(b.kind); ++a) {
        const auto n = static_cast<std::size_t>(cell.nodes[a]);
        x[a] = mesh_.nodes[n] + Vec3{u[4 * n], u[4 * n + 1], u[4 * n + 2]};
        mass += masses_[n] / cell.corners();
      }
      const double square = gradient_square(x, cell.is_hex()), volume = cell_volume(x, cell.is_hex());
      const double gain = gains.empty() ? 1 : gains[static_cast<std::size_t>(e)];
      least = std::min(least, gain * std::sqrt(mass * volume / (modulus * square)));
    }
  }
  return least < 1e300 ? least : 0;
}

std::vector<double> CellBatches::memory() const {
  std::vector<double> all;
  for (const Batch& b : batches_) {
    all.insert(all.end(), b.state.begin(), b.state.end());
    all.insert(all.end(), {b.stored, b.plastic, b.hourglass});
  }
  return all;
}

void CellBatches::restore_memory(const std::vector<double>& all) {
  std::size_t size = 0;
  for (const Batch& b : batches_) size += b.state.size() + 3;
  if (size != all.size()) throw std::invalid_argument("restart: the saved state belongs to another mesh");
  auto from = all.begin();
  for (Batch& b : batches_) {
    std::copy_n(from, b.state.size(), b.state.begin());
    from += static_cast<std::ptrdiff_t>(b.state.size());
    b.stored = *from++;
    b.plastic = *from++;
    b.hourglass = *from++;
  }
}

}  // namespace powbench::sim
