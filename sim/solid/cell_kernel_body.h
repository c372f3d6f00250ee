#pragma once

#include "sim/solid/cell_lanes.h"

/// Elastic cells in the reference configuration: no history, so nothing but the displacement is read. With the
/// displacement gradient H = sum W_m b_m (b_m = beta_m / V, reference)
///
///   J - 1 = tr H + I2(H) + det H, cof F = (1 + tr H) I - H^T + cof H, J F - cof F = J H + H^T + (I2 + det) I - cof
///   H,
///
/// which have no differences of nearly equal numbers at small strain. Nodal forces are minus the derivative of
/// V W(F) + sum k_hi q_hi^2 / 2, q_hi = (L_h - sum_j hourglass_hj B_j / V) . u_i.

namespace powbench::sim {
namespace {

template <class V>
POWBENCH_INLINE V least(const V& a, const V& b) {
  return a < b ? a : b;
}

/// First Piola stress of displacement gradient h; returns J.
template <bool linear, class Real, class V>
POWBENCH_INLINE V piola(const V (&h)[3][3], Real lambda, Real mu, V (&p)[3][3]) {
  const V trace = h[0][0] + h[1][1] + h[2][2];
  if constexpr (linear) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) p[i][j] = (h[i][j] + h[j][i]) * mu;
    for (int i = 0; i < 3; ++i) p[i][i] += trace * lambda;
    return trace + Real(1);
  } else {
    V c[3][3];  // cof H
    for (int i = 0; i < 3; ++i) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
      for (int j = 0; j < 3; ++j) {
        const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        c[i][j] = h[i1][j1] * h[i2][j2] - h[i1][j2] * h[i2][j1];
      }
    }
    const V second = c[0][0] + c[1][1] + c[2][2];
    const V det = h[0][0] * c[0][0] + h[0][1] * c[0][1] + h[0][2] * c[0][2];
    const V rest = second + det, growth = trace + rest, jacobian = growth + Real(1);
    const V shear = mu / jacobian, bulk = growth * lambda, stretch = trace + Real(1);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const V bent = c[i][j] - h[j][i];
        p[i][j] = shear * (jacobian * h[i][j] - bent) + bulk * bent;
      }
    const V diagonal = shear * rest + bulk * stretch;
    for (int i = 0; i < 3; ++i) p[i][i] += diagonal;
    return jacobian;
  }
}

/// `brick`: B is linear in L1 .. L3 and sees no hourglass mode.
template <bool brick, bool linear, class Real>
Real hex_forces(const ElasticBatch<Real>& batch) {
  using V = typename Lanes<Real>::V;
  using Vu = typename Lanes<Real>::Vu;
  constexpr int width = Lanes<Real>::width, halves = block_cells / width;
  constexpr int modes = brick ? 3 : 6, numbers = brick ? brick_numbers : hex_numbers;
  constexpr int at_volume = 3 * modes, at_k = at_volume + 1, at_hourglass = at_k + 12;
  V smallest = V{} + Real(1);
  for (int part = 0; part < batch.blocks * halves; ++part) {
    const int block = part / halves, lane = (part % halves) * width;
    const int* c = batch.nodes + block * 8 * block_cells + lane;
    const Real* s = batch.shape + static_cast<long>(block) * numbers * block_cells + lane;
    const auto number = [s](int k) -> V { return *reinterpret_cast<const Vu*>(s + k * block_cells); };
    V n[3][8], w[3][7];
    for (int a = 0; a < 8; ++a) gather(batch.u, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
    V h[3][3];
    for (int i = 0; i < 3; ++i) {
      to_modes(n[i], w[i]);
      for (int j = 0; j < 3; ++j) {
        h[i][j] = w[i][0] * number(j);
        for (int m = 1; m < modes; ++m) h[i][j] += w[i][m] * number(3 * m + j);
      }
    }
    V p[3][3];
    const V jacobian = piola<linear>(h, batch.lambda, batch.mu, p);
    smallest = least(smallest, jacobian);
    const V volume = number(at_volume);
    for (int i = 0; i < 3; ++i) {
      V g[7];
      V t[3] = {p[i][0] * volume, p[i][1] * volume, p[i][2] * volume};
      for (int m = 0; m < 4; ++m) {
        V q = w[i][3 + m];
        if constexpr (!brick)
          for (int j = 0; j < 3; ++j) q -= number(at_hourglass + 3 * m + j) * h[i][j];
        q *= number(at_k + 3 * m + i);
        g[3 + m] = -q;
        if constexpr (!brick)
          for (int j = 0; j < 3; ++j) t[j] -= q * number(at_hourglass + 3 * m + j);
      }
      for (int m = 0; m < modes; ++m) {
        const V force = t[0] * number(3 * m) + t[1] * number(3 * m + 1) + t[2] * number(3 * m + 2);
        if (m < 3)
          g[m] = -force;
        else
          g[m] -= force;
      }
      from_modes(g, n[i]);
    }
    for (int a = 0; a < 8; ++a) scatter(batch.f, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
  }
  Real result = smallest[0];
  for (int l = 1; l < width; ++l) result = smallest[l] < result ? smallest[l] : result;
  return result;
}

template <bool linear>
double tet_forces(const ElasticBatch<double>& batch) {
  using V = D8;
  constexpr int halves = 2;
  V smallest = V{} + 1.0;
  for (int part = 0; part < batch.blocks * halves; ++part) {
    const int block = part / halves, lane = (part % halves) * 8;
    const int* c = batch.nodes + block * 4 * block_cells + lane;
    const double* s = batch.shape + static_cast<long>(block) * tet_numbers * block_cells + lane;
    const auto number = [s](int k) -> V { return *reinterpret_cast<const D8u*>(s + k * block_cells); };
    V n[3][4];
    for (int a = 0; a < 4; ++a) gather(batch.u, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
    V h[3][3], p[3][3];
    for (int i = 0; i < 3; ++i) {
      const V d1 = n[i][1] - n[i][0], d2 = n[i][2] - n[i][0], d3 = n[i][3] - n[i][0];
      for (int j = 0; j < 3; ++j) h[i][j] = d1 * number(j) + d2 * number(3 + j) + d3 * number(6 + j);
    }
    smallest = least(smallest, piola<linear>(h, batch.lambda, batch.mu, p));
    const V volume = number(9);
    for (int i = 0; i < 3; ++i) {
      for (int a = 1; a < 4; ++a)
        n[i][a] = -volume *
                  (p[i][0] * number(3 * a - 3) + p[i][1] * number(3 * a - 2) + p[i][2] * number(3 * a - 1));
      n[i][0] = -(n[i][1] + n[i][2] + n[i][3]);
    }
    for (int a = 0; a < 4; ++a) scatter(batch.f, c + a * block_cells, n[0][a], n[1][a], n[2][a]);
  }
  double result = smallest[0];
  for (int l = 1; l < 8; ++l) result = smallest[l] < result ? smallest[l] : result;
  return result;
}

template <class Real>
Real brick_cells(const ElasticBatch<Real>& b, bool linear) {
  return linear ? hex_forces<true, true, Real>(b) : hex_forces<true, false, Real>(b);
}
template <class Real>
Real hex_cells(const ElasticBatch<Real>& b, bool linear) {
  return linear ? hex_forces<false, true, Real>(b) : hex_forces<false, false, Real>(b);
}
double tet_cells(const ElasticBatch<double>& b, bool linear) {
  return linear ? tet_forces<true>(b) : tet_forces<false>(b);
}

}  // namespace
}  // namespace powbench::sim
