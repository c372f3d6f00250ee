#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/units.h"
#include "dsp/vibration/ring.h"

namespace powbench::dsp {

namespace {

using Matrix = Eigen::MatrixXd;
using Eigen::Index;

/// Covariance of all windows of length L, forward only: (L, L). Along a diagonal one product leaves and one enters.
Matrix window_covariance(std::span<const double> x, Index L) {
  const auto at = [&](Index i) { return x[static_cast<std::size_t>(i)]; };
  const Index windows = static_cast<Index>(x.size()) - L + 1;
  Matrix R(L, L);
  for (Index lag = 0; lag < L; ++lag) {
    double sum = 0;
    for (Index k = 0; k < windows; ++k) sum += at(k) * at(k + lag);
    for (Index i = 0; i + lag < L; ++i) {
      R(i, i + lag) = R(i + lag, i) = sum;
      if (i + lag + 1 < L) sum += at(i + windows) * at(i + lag + windows) - at(i) * at(i + lag);
    }
  }
  return R;
}

}  // namespace

std::vector<Pole> find_poles(std::span<const double> x, double dt, double noise, int max_modes, double low,
                             double high) {
  const auto n = static_cast<Index>(x.size());
  const Index L = std::min<Index>(64, n / 3);
  if (L < 8 || max_modes <= 0) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> eig(window_covariance(x, L));
  const auto windows = static_cast<double>(n - L + 1);
  // White noise alone spreads the eigenvalues up to about this (Marchenko-Pastur edge, with a margin).
  const double edge =
      1.3 * noise * noise * windows * std::pow(1 + std::sqrt(static_cast<double>(L) / windows), 2);
  Index order = 0;
  while (order < 2 * max_modes + 2 && order < L / 2 && eig.eigenvalues()[L - 1 - order] > edge) ++order;
  if (order < 2) return {};
  const Matrix U = eig.eigenvectors().rightCols(order);
  const Matrix A = U.topRows(L - 1), B = U.bottomRows(L - 1);
  const Matrix phi = (A.transpose() * A).ldlt().solve(A.transpose() * B);
  const Eigen::EigenSolver<Matrix> poles(phi, false);
  std::vector<Pole> out;
  for (Index k = 0; k < order; ++k) {
    const std::complex<double> z = poles.eigenvalues()[k];
    if (z.imag() <= 0 || std::abs(z) > 1.02 || std::abs(z) < 1e-3) continue;
    const std::complex<double> s = std::log(z) / dt;
    const double hertz = s.imag() / (2 * pi);
    if (hertz < low || hertz > high) continue;
    const double decay = std::max(-s.real(), 0.002 * s.imag());
    if (decay > 0.12 * s.imag()) continue;
    out.push_back({hertz, decay});
  }
  if (out.size() > static_cast<std::size_t>(max_modes)) {
    std::sort(out.begin(), out.end(),
              [](const Pole& a, const Pole& b) { return a.decay / a.hertz < b.decay / b.hertz; });
    out.resize(static_cast<std::size_t>(max_modes));
  }
  return out;
}

}  // namespace powbench::dsp
