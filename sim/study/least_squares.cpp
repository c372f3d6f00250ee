#include "sim/study/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace powbench::sim {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

double sum_of_squares(const std::vector<double>& r) {
  double sum = 0;
  for (const double v : r) sum += v * v;
  return sum;
}

Eigen::Map<const Matrix> view(const Jacobian& j) {
  return {j.values.data(), static_cast<Eigen::Index>(j.rows), static_cast<Eigen::Index>(j.columns)};
}

Eigen::Map<const Eigen::VectorXd> view(const std::vector<double>& v) {
  return {v.data(), static_cast<Eigen::Index>(v.size())};
}

/// The damped step, cut where it would leave the cube. `damping`: relative to the largest diagonal of `normal`.
std::vector<double> stepped(const std::vector<double>& point, Eigen::MatrixXd normal,
                            const Eigen::VectorXd& slope, double damping) {
  normal.diagonal().array() += damping * normal.diagonal().maxCoeff();
  const Eigen::VectorXd step = normal.ldlt().solve(-slope);
  std::vector<double> to = point;
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] = std::clamp(to[i] + step[static_cast<Eigen::Index>(i)], 0.0, 1.0);
  return to;
}

}  // namespace

Jacobian jacobian(const Residuals& f, std::span<const double> point, std::span<const double> residuals,
                  double step, Team& team) {
  Jacobian j{residuals.size(), point.size(), std::vector<double>(residuals.size() * point.size())};
  for_each_index(team, static_cast<int>(point.size()), [&](int i) {
    const auto c = static_cast<std::size_t>(i);
    std::vector<double> moved(point.begin(), point.end());
    const double h = moved[c] < 0.5 ? step : -step;
    moved[c] += h;
    const auto r = f(moved);
    for (std::size_t k = 0; k < j.rows; ++k) j.values[k * j.columns + c] = (r[k] - residuals[k]) / h;
  });
  return j;
}

Refined refine(const Residuals& f, std::vector<double> start, const RefineOptions& options, Team& team) {
  Refined best{std::move(start), {}, 0, 0};
  best.residuals = f(best.point);
  best.sum = sum_of_squares(best.residuals);
  double damping = options.damping;
  for (; best.iterations < options.iterations; ++best.iterations) {
    const Jacobian jac = jacobian(f, best.point, best.residuals, options.step, team);
    const auto j = view(jac);
    const Eigen::MatrixXd normal = j.transpose() * j;
    const Eigen::VectorXd slope = j.transpose() * view(best.residuals);
    const double before = best.sum;
    for (int attempt = 0; attempt < 6; ++attempt, damping *= 6) {
      auto trial = stepped(best.point, normal, slope, damping);
      auto residuals = f(trial);
      const double sum = sum_of_squares(residuals);
      if (!(sum < best.sum)) continue;
      best.point = std::move(trial);
      best.residuals = std::move(residuals);
      best.sum = sum;
      damping = std::max(damping / 4, 1e-9);
      break;
    }
    if (!(best.sum < before * (1 - options.enough))) break;
  }
  return best;
}

Refined refine_near(const Residuals& f, std::vector<double> start, const Jacobian& at_start,
                    int evaluations) {
  constexpr double smallest = 1e-4;  // of a step
  constexpr double enough = 1e-3;    // relative decrease of the sum below which it ends
  constexpr int failures_allowed = 6;
  Refined best{std::move(start), {}, 0, 1};
  best.residuals = f(best.point);
  best.sum = sum_of_squares(best.residuals);
  Eigen::MatrixXd j = view(at_start);
  double damping = 1e-3;
  for (int failures = 0; best.iterations < evaluations && failures < failures_allowed;) {
    auto trial = stepped(best.point, j.transpose() * j, j.transpose() * view(best.residuals), damping);
    const Eigen::VectorXd step = view(trial) - view(best.point);
    if (step.norm() < smallest) break;
    auto residuals = f(trial);
    ++best.iterations;
    const Eigen::VectorXd surprise = view(residuals) - view(best.residuals) - j * step;
    j += surprise * step.transpose() / step.squaredNorm();  // a step that fails teaches as much
    const double sum = sum_of_squares(residuals);
    if (!(sum < best.sum)) {
      damping *= 4;
      ++failures;
      continue;
    }
    const bool done = sum > best.sum * (1 - enough);
    best.point = std::move(trial);
    best.residuals = std::move(residuals);
    best.sum = sum;
    damping = std::max(damping / 4, 1e-9);
    failures = 0;
    if (done) break;
  }
  return best;
}

Identifiability identifiability(const Jacobian& jac, double prior_deviation) {
  const auto n = static_cast<Eigen::Index>(jac.columns);
  const Eigen::MatrixXd j = view(jac);
  Eigen::MatrixXd information = j.transpose() * j;
  if (prior_deviation > 0) information.diagonal().array() += 1 / (prior_deviation * prior_deviation);
  const Eigen::MatrixXd covariance = information.completeOrthogonalDecomposition().pseudoInverse();
  // without a prior: against the flat one between the bounds, whose variance is 1/12 of their square
  constexpr double flat = 12;
  Eigen::MatrixXd bounded;
  if (!(prior_deviation > 0)) {
    bounded = information;
    bounded.diagonal().array() += flat;
    bounded = bounded.inverse().eval();
  }
  Identifiability result;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double deviation = std::sqrt(std::max(covariance(i, i), 0.0));
    result.deviation.push_back(deviation);
    if (prior_deviation > 0)
      result.data_share.push_back(1 - std::min(1.0, std::pow(deviation / prior_deviation, 2)));
    else
      result.data_share.push_back(1 - flat * bounded(i, i));
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k) {
      const double scale = std::sqrt(covariance(i, i) * covariance(k, k));
      result.correlation.push_back(scale > 0 ? covariance(i, k) / scale : (i == k ? 1.0 : 0.0));
    }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(j);  // few columns: what BDCSVD itself would use
  for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
    result.singular.push_back(svd.singularValues()[i]);
  return result;
}

}  // namespace powbench::sim
