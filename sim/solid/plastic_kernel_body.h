#pragma once

#include "sim/solid/cell_kernel_body.h"

/// Plastic cells in the current configuration. Strain rate and spin come from the mean gradient at mid-step, the
/// stress is turned by the Jaumann rate, tried elastically and returned radially to the von Mises cylinder; forces act
/// at the end of the step. Hourglass forces of hexahedra grow with the rate of their modes.

namespace powbench::sim {
namespace {

/// beta_1 .. beta_6 of the coordinates' modes (W_m, m = 1 .. 6) and the volume; see hex_shape.h.
template <class V>
POWBENCH_INLINE V mean_gradient(const V (&w)[3][7], V (&beta)[6][3]) {
  constexpr double scale = 1.0 / 64, third = 1.0 / 192;
  const auto product = [&w](int a, int b, int i) -> V {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    return w[j][a] * w[k][b] - w[k][a] * w[j][b];
  };
  V volume{};
  for (int i = 0; i < 3; ++i) {
    const V x23 = product(1, 2, i) * scale;
    beta[0][i] = x23 + product(5, 4, i) * third;
    beta[1][i] = product(2, 0, i) * scale + product(3, 5, i) * third;
    beta[2][i] = product(0, 1, i) * scale + product(4, 3, i) * third;
    beta[3][i] = (product(2, 4, i) + product(5, 1, i)) * third;
    beta[4][i] = (product(3, 2, i) + product(0, 5, i)) * third;
    beta[5][i] = (product(1, 3, i) + product(4, 0, i)) * third;
    volume +=
        w[i][0] * beta[0][i] + w[i][5] * (product(1, 3, i) * third) + w[i][4] * (product(3, 2, i) * third);
  }
  return volume;
}

struct Flow {
  double lambda, mu, yield, hardening, dt;
};

/// Turns, tries and returns the stress s (xx yy zz xy yz xz); gives the plastic strain increment and the radius before.
template <class V>
POWBENCH_INLINE V update_stress(const V (&l)[3][3], const Flow& m, V (&s)[6], V& plastic, V& flow_stress) {
  const V half = V{} + 0.5 * m.dt;
  const V wxy = (l[0][1] - l[1][0]) * half, wyz = (l[1][2] - l[2][1]) * half,
          wxz = (l[0][2] - l[2][0]) * half;
  const V trace = (l[0][0] + l[1][1] + l[2][2]) * (m.lambda * m.dt);
  const double twice = 2 * m.mu * m.dt, once = m.mu * m.dt;
  V t[6];
  t[0] = s[0] + (wxy * s[3] + wxz * s[5]) * 2.0 + trace + l[0][0] * twice;
  t[1] = s[1] + (wyz * s[4] - wxy * s[3]) * 2.0 + trace + l[1][1] * twice;
  t[2] = s[2] - (wxz * s[5] + wyz * s[4]) * 2.0 + trace + l[2][2] * twice;
  t[3] = s[3] + wxy * (s[1] - s[0]) + wxz * s[4] + wyz * s[5] + (l[0][1] + l[1][0]) * once;
  t[4] = s[4] + wyz * (s[2] - s[1]) - wxz * s[3] - wxy * s[5] + (l[1][2] + l[2][1]) * once;
  t[5] = s[5] + wxz * (s[2] - s[0]) + wxy * s[4] - wyz * s[3] + (l[0][2] + l[2][0]) * once;
  const V mean = (t[0] + t[1] + t[2]) * (1.0 / 3);
  const V d0 = t[0] - mean, d1 = t[1] - mean, d2 = t[2] - mean;
  const V square = (d0 * d0 + d1 * d1 + d2 * d2) * 1.5 + (t[3] * t[3] + t[4] * t[4] + t[5] * t[5]) * 3.0;
  V mises;
  for (int k = 0; k < 8; ++k) mises[k] = __builtin_sqrt(square[k]);
  const V limit = plastic * m.hardening + m.yield;
  const V over = mises - limit, zero{};
  const V step = (over > zero ? over : zero) / (3 * m.mu + m.hardening);
  const V keep = V{} + 1.0 - step * (3 * m.mu) / (over > zero ? mises : V{} + 1.0);
  plastic += step;
  flow_stress = limit + step * (0.5 * m.hardening);
  s[0] = d0 * keep + mean;
  s[1] = d1 * keep + mean;
  s[2] = d2 * keep + mean;
  for (int k = 3; k < 6; ++k) s[k] = t[k] * keep;
  return step;
}

/// Strain rate contracted with a stress, times the volume gives power.
template <class V>
POWBENCH_INLINE V power(const V (&s)[6], const V (&l)[3][3]) {
  return s[0] * l[0][0] + s[1] * l[1][1] + s[2] * l[2][2] + s[3] * (l[0][1] + l[1][0]) +
         s[4] * (l[1][2] + l[2][1]) + s[5] * (l[0][2] + l[2][0]);
}

/// Modes of positions now (w), at mid-step (middle) and of the velocity (rate), one component after the other.
template <class V>
POWBENCH_INLINE void load_motion(const PlasticBatch& batch, const int* c, V (&w)[3][7], V (&middle)[3][7],
                                 V (&rate)[3][7]) {
  V n[3][8];
  for (int a = 0; a < 8; ++a) gather(batch.v, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
  for (int i = 0; i < 3; ++i) to_modes(n[i], rate[i]);
  for (int a = 0; a < 8; ++a) gather(batch.x, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
  const double half = 0.5 * batch.dt;
  for (int i = 0; i < 3; ++i) {
    to_modes(n[i], w[i]);
    for (int m = 0; m < 7; ++m) middle[i][m] = w[i][m] - rate[i][m] * half;
  }
}

double plastic_cells(PlasticBatch& batch) {
  using V = D8;
  V smallest = V{} + 1e300, stored{}, lost{}, hourglass_work{};
  const Flow material{batch.lambda, batch.mu, batch.yield, batch.hardening, batch.dt};
  for (int part = 0; part < batch.blocks * 2; ++part) {
    const int block = part / 2, lane = (part % 2) * 8;
    const int* c = batch.nodes + block * 8 * block_cells + lane;
    double* state = batch.state + static_cast<long>(block) * plastic_numbers * block_cells + lane;
    const auto number = [state](int k) -> D8u& { return *reinterpret_cast<D8u*>(state + k * block_cells); };
    V w[3][7], middle[3][7], rate[3][7], beta[6][3], l[3][3];
    load_motion(batch, c, w, middle, rate);
    const V mid_volume = mean_gradient(middle, beta);
    const V spare = mid_volume == V{} ? V{} + 1.0 : mid_volume;  // unused lanes
    const V inverse = 1.0 / spare;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        l[i][j] = rate[i][0] * beta[0][j];
        for (int m = 1; m < 6; ++m) l[i][j] += rate[i][m] * beta[m][j];
        l[i][j] *= inverse;
      }
    V s[6], plastic = number(6), flow_stress;
    for (int k = 0; k < 6; ++k) s[k] = number(k);
    const V before = power(s, l);
    const V step = update_stress(l, material, s, plastic, flow_stress);
    stored += (before + power(s, l)) * mid_volume * (0.5 * batch.dt);
    lost += flow_stress * step * mid_volume;
    for (int k = 0; k < 6; ++k) number(k) = s[k];
    number(6) = plastic;
    const V volume = mean_gradient(w, beta);
    smallest = least(smallest, mid_volume == V{} ? V{} + 1e300 : volume);
    V square{};  // B:B = 8 sum of beta^2
    for (int m = 0; m < 6; ++m)
      for (int j = 0; j < 3; ++j) square += beta[m][j] * beta[m][j];
    const V full = mid_volume == V{} ? V{} + 1.0 : volume;
    const V size = 1.0 / full, stiffness = square * size * (8 * batch.hourglass / 72);
    const V t[3][3] = {{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
    V n[3][8];
    for (int i = 0; i < 3; ++i) {
      V g[7], force[3] = {t[i][0], t[i][1], t[i][2]};
      for (int m = 0; m < 4; ++m) {
        V grow = rate[i][3 + m];
        for (int j = 0; j < 3; ++j) grow -= middle[j][3 + m] * l[i][j];
        const V old = number(7 + 3 * m + i), q = old + stiffness * grow * batch.dt;
        number(7 + 3 * m + i) = q;
        hourglass_work += (old + q) * grow * (0.5 * batch.dt);
        g[3 + m] = -q;
        for (int j = 0; j < 3; ++j) force[j] -= q * w[j][3 + m] * size;
      }
      for (int m = 0; m < 6; ++m) {
        const V pull = force[0] * beta[m][0] + force[1] * beta[m][1] + force[2] * beta[m][2];
        if (m < 3)
          g[m] = -pull;
        else
          g[m] -= pull;
      }
      from_modes(g, n[i]);
    }
    for (int a = 0; a < 8; ++a) scatter(batch.f, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
  }
  double result = smallest[0];
  for (int k = 0; k < 8; ++k) {
    result = smallest[k] < result ? smallest[k] : result;
    batch.stored += stored[k];
    batch.plastic_work += lost[k];
    batch.hourglass_work += hourglass_work[k];
  }
  return result;
}

/// Edges 1 .. 3 of tetrahedra from corner 0, and their cross products b_1 .. b_3; gives six times the volume.
template <class V>
POWBENCH_INLINE V tet_gradient(const V (&d)[3][3], V (&b)[3][3]) {
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) {
      const int next = (k + 1) % 3, last = (k + 2) % 3, j = (i + 1) % 3, l = (i + 2) % 3;
      b[k][i] = d[next][j] * d[last][l] - d[next][l] * d[last][j];
    }
  return d[0][0] * b[0][0] + d[0][1] * b[0][1] + d[0][2] * b[0][2];
}

double plastic_tets(PlasticBatch& batch) {
  using V = D8;
  V smallest = V{} + 1e300, stored{}, lost{};
  const Flow material{batch.lambda, batch.mu, batch.yield, batch.hardening, batch.dt};
  const double half = 0.5 * batch.dt;
  for (int part = 0; part < batch.blocks * 2; ++part) {
    const int block = part / 2, lane = (part % 2) * 8;
    const int* c = batch.nodes + block * 4 * block_cells + lane;
    double* state = batch.state + static_cast<long>(block) * plastic_tet_numbers * block_cells + lane;
    const auto number = [state](int k) -> D8u& { return *reinterpret_cast<D8u*>(state + k * block_cells); };
    V x[3][4], v[3][4], rate[3][3], now[3][3], middle[3][3], b[3][3], l[3][3];
    for (int a = 0; a < 4; ++a) {
      gather(batch.x, c + a * block_cells, x[0][a], x[1][a], x[2][a]);
      gather(batch.v, c + a * block_cells, v[0][a], v[1][a], v[2][a]);
    }
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) {
        rate[k][i] = v[i][k + 1] - v[i][0];
        now[k][i] = x[i][k + 1] - x[i][0];
        middle[k][i] = now[k][i] - rate[k][i] * half;
      }
    const V mid_six = tet_gradient(middle, b);
    const V inverse = 1.0 / (mid_six == V{} ? V{} + 1.0 : mid_six);  // unused lanes
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        l[i][j] = (rate[0][i] * b[0][j] + rate[1][i] * b[1][j] + rate[2][i] * b[2][j]) * inverse;
    V s[6], plastic = number(6), flow_stress;
    for (int k = 0; k < 6; ++k) s[k] = number(k);
    const V before = power(s, l);
    const V step = update_stress(l, material, s, plastic, flow_stress);
    stored += (before + power(s, l)) * mid_six * (half / 6);
    lost += flow_stress * step * mid_six * (1.0 / 6);
    for (int k = 0; k < 6; ++k) number(k) = s[k];
    number(6) = plastic;
    const V six = tet_gradient(now, b);
    smallest = least(smallest, mid_six == V{} ? V{} + 1e300 : six * (1.0 / 6));
    const V t[3][3] = {{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
    V n[3][4];
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k)
        n[i][k + 1] = (t[i][0] * b[k][0] + t[i][1] * b[k][1] + t[i][2] * b[k][2]) * (-1.0 / 6);
      n[i][0] = -(n[i][1] + n[i][2] + n[i][3]);
    }
    for (int a = 0; a < 4; ++a) scatter(batch.f, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
  }
  double result = smallest[0];
  for (int k = 0; k < 8; ++k) {
    result = smallest[k] < result ? smallest[k] : result;
    batch.stored += stored[k];
    batch.plastic_work += lost[k];
  }
  return result;
}

POWBENCH_INLINE D4 widen(const double* p) {
  return *reinterpret_cast<const D4u*>(p);
}
POWBENCH_INLINE D4 widen(const float* p) {
  return __builtin_convertvector(*reinterpret_cast<const S4u*>(p), D4);
}

template <class Real>
void advance_nodes(const NodeRange<Real>& range) {
  const double keep = 1 - range.damping, scale = 1 / (1 + range.damping);
  for (int n = range.first; n < range.last; ++n) {
    D4 f{};
    for (int k = range.slot_begin[n]; k < range.slot_begin[n + 1]; ++k) f += widen(range.f + range.slots[k]);
    double* const velocity = range.v + 4 * static_cast<long>(n);
    double* const place = range.u + 4 * static_cast<long>(n);
    const D4 v =
        (widen(velocity) * keep + f * widen(range.inverse_mass + 4 * static_cast<long>(n)) * range.dt) *
        scale;
    *reinterpret_cast<D4u*>(velocity) = v;
    *reinterpret_cast<D4u*>(place) += v * range.drift;
  }
}

}  // namespace

#define POWBENCH_CELL_KERNEL(function, title)                                                            \
  const CellKernel& function() {                                                                         \
    static constexpr CellKernel kernel{                                                                  \
        title,     brick_cells<double>, hex_cells<double>, brick_cells<float>,    hex_cells<float>,      \
        tet_cells, plastic_cells,       plastic_tets,      advance_nodes<double>, advance_nodes<float>}; \
    return kernel;                                                                                       \
  }

}  // namespace powbench::sim
