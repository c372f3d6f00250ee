#include "dsp/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/gram.h"

namespace powbench::dsp {

namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

std::span<const double> view(const Vector& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}
std::span<double> view(Vector& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

void clamp(Vector& x, std::span<const FreeParameter> p) {
  for (Index j = 0; j < x.size(); ++j) {
    const auto& q = p[static_cast<std::size_t>(j)];
    x[j] = std::clamp(x[j], q.lower, q.upper);
  }
}

/// Central differences; one-sided at a bound.
void jacobian(const Residuals& f, std::span<const FreeParameter> p, const Vector& x, Matrix& J) {
  Vector up(J.rows()), down(J.rows()), at(x);
  for (Index j = 0; j < x.size(); ++j) {
    const auto& q = p[static_cast<std::size_t>(j)];
    const double hi = std::min(x[j] + q.step, q.upper), lo = std::max(x[j] - q.step, q.lower);
    at[j] = hi;
    f(view(std::as_const(at)), view(up));
    at[j] = lo;
    f(view(std::as_const(at)), view(down));
    at[j] = x[j];
    J.col(j) = hi > lo ? Vector((up - down) / (hi - lo)) : Vector::Zero(J.rows());
  }
}

std::vector<double> inverse_of(const Matrix& normal) {
  const Index n = normal.rows();
  const Vector d = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix scaled = d.asDiagonal() * normal * d.asDiagonal();
  const Matrix inverse =
      d.asDiagonal() * Matrix(scaled.ldlt().solve(Matrix::Identity(n, n))) * d.asDiagonal();
  std::vector<double> out(static_cast<std::size_t>(n * n));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(out.data(), n, n) =
      inverse;
  return out;
}

}  // namespace

double LeastSquares::u(std::size_t i) const {
  const double v = covariance[i * x.size() + i];
  return v >= 0 && std::isfinite(v) ? std::sqrt(v) : std::numeric_limits<double>::infinity();
}

LeastSquares levenberg_marquardt(const Residuals& f, std::size_t rows, std::span<const FreeParameter> p,
                                 int max_iterations, const Derivatives& derivatives) {
  const auto m = static_cast<Index>(rows), n = static_cast<Index>(p.size());
  Vector x(n), r(m), trial(m);
  for (Index j = 0; j < n; ++j) x[j] = p[static_cast<std::size_t>(j)].start;
  clamp(x, p);
  f(view(std::as_const(x)), view(r));
  double cost = r.squaredNorm(), damping = 1e-3;
  Matrix J(m, n), normal(n, n);
  const auto differentiate = [&] {
    if (derivatives)
      derivatives(view(std::as_const(x)), {J.data(), static_cast<std::size_t>(J.size())});
    else
      jacobian(f, p, x, J);
  };
  LeastSquares out;
  for (; out.iterations < max_iterations && !out.converged; ++out.iterations) {
    differentiate();
    normal = cross<Matrix>(J, J);
    const Vector gradient = cross<Matrix>(J, r);
    bool accepted = false;
    for (int tries = 0; tries < 12 && !accepted; ++tries) {
      Matrix damped = normal;
      damped.diagonal() += damping * normal.diagonal().cwiseMax(1e-12);
      Vector next = x - damped.ldlt().solve(gradient);
      if (!next.allFinite()) {
        damping *= 10;
        continue;
      }
      clamp(next, p);
      f(view(std::as_const(next)), view(trial));
      const double next_cost = trial.squaredNorm();
      if (next_cost < cost || (next_cost == cost && next == x)) {
        accepted = true;
        out.converged = cost - next_cost < 1e-6;
        x = next;
        r = trial;
        cost = next_cost;
        damping = std::max(damping * 0.2, 1e-9);
      } else {
        damping *= 6;
      }
    }
    if (!accepted) out.converged = true;  // no descent left along any damped direction
  }
  differentiate();
  normal = cross<Matrix>(J, J);
  out.covariance = inverse_of(normal);
  out.x.assign(x.data(), x.data() + n);
  out.chi2 = cost;
  return out;
}

LeastSquares linear_least_squares(std::span<const std::vector<double>> columns, std::span<const double> y) {
  const auto m = static_cast<Index>(y.size()), n = static_cast<Index>(columns.size());
  Matrix A(m, n);
  for (Index j = 0; j < n; ++j)
    A.col(j) = Eigen::Map<const Vector>(columns[static_cast<std::size_t>(j)].data(), m);
  const Eigen::Map<const Vector> b(y.data(), m);
  const Eigen::ColPivHouseholderQR<Matrix> qr(A);
  const Vector c = qr.solve(b);
  LeastSquares out;
  out.converged = qr.rank() == n;
  out.x.assign(c.data(), c.data() + n);
  out.chi2 = (b - A * c).squaredNorm();
  if (out.converged) {
    out.covariance = inverse_of(cross<Matrix>(A, A));
  } else {
    out.covariance.assign(static_cast<std::size_t>(n * n), std::numeric_limits<double>::infinity());
  }
  return out;
}

}  // namespace powbench::dsp
