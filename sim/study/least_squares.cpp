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

/// Each by itself.
ManyResiduals one_by_one(const Residuals& f) {
  return [&f](std::span<const std::vector<double>> points, Team& team) {
    std::vector<std::vector<double>> all(points.size());
    for_each_index(team, static_cast<int>(points.size()), [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      all[k] = f(points[k]);
    });
    return all;
  };
}

/// `refine_near`, which waits wherever it wants residuals.
class NearSearch {
 public:
  NearSearch(std::vector<double> start, const Jacobian& at_start, int evaluations)
      : best_{{}, {}, 0, 0}, trial_(std::move(start)), j_(view(at_start)), evaluations_(evaluations) {}

  bool wants() const { return wants_; }
  const std::vector<double>& wanted() const { return trial_; }
  const Refined& best() const { return best_; }

  void take(std::vector<double> residuals) {
    if (best_.iterations++ == 0) {
      keep(std::move(residuals));
    } else if (judge(std::move(residuals))) {
      wants_ = false;
      return;
    }
    wants_ = propose();
  }

 private:
  static constexpr double smallest = 1e-4;  // of a step
  static constexpr double enough = 1e-3;    // relative decrease of the sum below which it ends
  static constexpr int failures_allowed = 6;

  void keep(std::vector<double> residuals) {
    best_.point = trial_;
    best_.residuals = std::move(residuals);
    best_.sum = sum_of_squares(best_.residuals);
  }

  bool propose() {
    if (best_.iterations >= evaluations_ || failures_ >= failures_allowed) return false;
    trial_ = stepped(best_.point, j_.transpose() * j_, j_.transpose() * view(best_.residuals), damping_);
    step_ = view(trial_) - view(best_.point);
    return !(step_.norm() < smallest);
  }

  /// True: it ends.
  bool judge(std::vector<double> residuals) {
    const Eigen::VectorXd surprise = view(residuals) - view(best_.residuals) - j_ * step_;
    j_ += surprise * step_.transpose() / step_.squaredNorm();  // a step that fails teaches as much
    const double sum = sum_of_squares(residuals);
    if (!(sum < best_.sum)) {
      damping_ *= 4;
      ++failures_;
      return false;
    }
    const bool done = sum > best_.sum * (1 - enough);
    keep(std::move(residuals));
    damping_ = std::max(damping_ / 4, 1e-9);
    failures_ = 0;
    return done;
  }

  Refined best_;
  std::vector<double> trial_;
  Eigen::MatrixXd j_;
  Eigen::VectorXd step_;
  double damping_ = 1e-3;
  int evaluations_, failures_ = 0;
  bool wants_ = true;
};

}  // namespace

Jacobian jacobian(const ManyResiduals& f, std::span<const double> point, std::span<const double> residuals,
                  double step, Team& team) {
  Jacobian j{residuals.size(), point.size(), std::vector<double>(residuals.size() * point.size())};
  std::vector<std::vector<double>> moved(j.columns, {point.begin(), point.end()});
  const auto change = [&](std::size_t c) { return point[c] < 0.5 ? step : -step; };
  for (std::size_t c = 0; c < j.columns; ++c) moved[c][c] += change(c);
  const auto r = f(moved, team);
  for (std::size_t c = 0; c < j.columns; ++c)
    for (std::size_t k = 0; k < j.rows; ++k)
      j.values[k * j.columns + c] = (r[c][k] - residuals[k]) / change(c);
  return j;
}

Jacobian jacobian(const Residuals& f, std::span<const double> point, std::span<const double> residuals,
                  double step, Team& team) {
  return jacobian(one_by_one(f), point, residuals, step, team);
}

Refined refine(const Residuals& f, std::vector<double> start, const RefineOptions& options, Team& team) {
  return refine(one_by_one(f), std::move(start), options, team);
}

Refined refine(const ManyResiduals& f, std::vector<double> start, const RefineOptions& options, Team& team) {
  Refined best{std::move(start), {}, 0, 0};
  const auto at = [&](const std::vector<double>& point) { return f(std::span(&point, 1), team).front(); };
  best.residuals = at(best.point);
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
      auto residuals = at(trial);
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

std::vector<Refined> refine_near(const ResidualsOf& residuals, std::size_t count,
                                 const std::vector<double>& start, const Jacobian& at_start,
                                 int evaluations) {
  std::vector<NearSearch> searches(count, NearSearch(start, at_start, evaluations));
  while (true) {
    std::vector<PointOf> points;
    for (std::size_t k = 0; k < count; ++k)
      if (searches[k].wants()) points.push_back({k, searches[k].wanted()});
    if (points.empty()) break;
    auto all = residuals(points);
    for (std::size_t k = 0; k < points.size(); ++k) searches[points[k].problem].take(std::move(all[k]));
  }
  std::vector<Refined> results;
  for (auto& search : searches) results.push_back(search.best());
  return results;
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
