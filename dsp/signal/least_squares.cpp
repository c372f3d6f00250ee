#include "dsp/signal/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dsp/signal/gram.h"

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

/// Normal equations of up to `few` parameters live on the stack: most fits have no more, and there are thousands of
/// them in a record.
constexpr int few = 8;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, few, few>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, few, 1>;

template <class M>
std::vector<double> inverse_of(const M& normal) {
  const Index n = normal.rows();
  const M d = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal();
  const M scaled = d * normal * d;
  const M inverse = d * M(scaled.ldlt().solve(M::Identity(n, n))) * d;
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

namespace {

template <class M, class V>
LeastSquares descend(const Residuals& f, std::size_t rows, std::span<const FreeParameter> p,
                     int max_iterations, const Derivatives& derivatives, double least_gain) {
  const auto m = static_cast<Index>(rows), n = static_cast<Index>(p.size());
  Vector x(n), r(m), trial(m), next(n);
  for (Index j = 0; j < n; ++j) x[j] = p[static_cast<std::size_t>(j)].start;
  clamp(x, p);
  f(view(std::as_const(x)), view(r));
  double cost = r.squaredNorm(), damping = 1e-3;
  Matrix J(m, n);
  M normal(n, n);
  const auto differentiate = [&] {
    if (derivatives)
      derivatives(view(std::as_const(x)), {J.data(), static_cast<std::size_t>(J.size())});
    else
      jacobian(f, p, x, J);
  };
  LeastSquares out;
  for (; out.iterations < max_iterations && !out.converged; ++out.iterations) {
    differentiate();
    normal = cross<M>(J, J);
    const V gradient = cross<V>(J, r);
    bool accepted = false;
    for (int tries = 0; tries < 12 && !accepted; ++tries) {
      M damped = normal;
      damped.diagonal() += damping * normal.diagonal().cwiseMax(1e-12);
      next = x - damped.ldlt().solve(gradient);
      if (!next.allFinite()) {
        damping *= 10;
        continue;
      }
      clamp(next, p);
      f(view(std::as_const(next)), view(trial));
      const double next_cost = trial.squaredNorm();
      if (next_cost < cost || (next_cost == cost && next == x)) {
        accepted = true;
        out.converged = cost - next_cost < least_gain;
        x.swap(next);
        r.swap(trial);
        cost = next_cost;
        damping = std::max(damping * 0.2, 1e-9);
      } else {
        damping *= 6;
      }
    }
    if (!accepted) out.converged = true;  // no descent left along any damped direction
  }
  differentiate();
  normal = cross<M>(J, J);
  out.covariance = inverse_of(normal);
  out.x.assign(x.data(), x.data() + n);
  out.chi2 = cost;
  return out;
}

}  // namespace

LeastSquares levenberg_marquardt(const Residuals& f, std::size_t rows, std::span<const FreeParameter> p,
                                 int max_iterations, const Derivatives& derivatives, double least_gain) {
  return p.size() <= few
             ? descend<SmallMatrix, SmallVector>(f, rows, p, max_iterations, derivatives, least_gain)
             : descend<Matrix, Vector>(f, rows, p, max_iterations, derivatives, least_gain);
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
    out.covariance = n <= few ? inverse_of(cross<SmallMatrix>(A, A)) : inverse_of(cross<Matrix>(A, A));
  } else {
    out.covariance.assign(static_cast<std::size_t>(n * n), std::numeric_limits<double>::infinity());
  }
  return out;
}

double linear_misfit(std::span<const double> columns, std::size_t count, std::span<const double> y) {
  const auto m = static_cast<Index>(y.size()), n = static_cast<Index>(count);
  const Eigen::Map<const Matrix> A(columns.data(), m, n);
  const Eigen::Map<const Vector> b(y.data(), m);
  Matrix normal = cross<Matrix>(A, A);
  normal.diagonal() *= 1 + 1e-13;  // columns that are no two stay solvable
  const Vector c = normal.ldlt().solve(Vector(cross<Matrix>(A, b)));
  return (b - A * c).squaredNorm();
}

}  // namespace powbench::dsp
