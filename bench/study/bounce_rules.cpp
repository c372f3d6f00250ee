#include "bench/study/bounce_rules.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bench/study/synthetic_device.h"
#include "core/units.h"

namespace powbench::bench {
namespace {

/// Ridge on all but the first column.
double fitted(const Eigen::MatrixXd& a, const Eigen::VectorXd& y, const Eigen::VectorXd& at, double ridge) {
  Eigen::MatrixXd normal = a.transpose() * a;
  for (Eigen::Index i = 1; i < normal.rows(); ++i) normal(i, i) += ridge;
  return at.dot(normal.ldlt().solve(a.transpose() * y));
}

Eigen::VectorXd bounces_of(const std::vector<Known>& known) {
  Eigen::VectorXd y(static_cast<Eigen::Index>(known.size()));
  for (std::size_t k = 0; k < known.size(); ++k) y[static_cast<Eigen::Index>(k)] = known[k].log_bounce;
  return y;
}

}  // namespace

double median_rule(const std::vector<Known>& known, double, const std::vector<double>&) {
  std::vector<double> list;
  for (const auto& k : known) list.push_back(k.log_bounce);
  return median_of(std::move(list));
}

double nearest_rule(const std::vector<Known>& known, double angle, const std::vector<double>&) {
  const auto distance = [&](const Known& k) { return std::fabs(std::remainder(k.angle - angle, pi)); };
  return std::min_element(known.begin(), known.end(),
                          [&](const Known& a, const Known& b) { return distance(a) < distance(b); })
      ->log_bounce;
}

double interpolation_rule(const std::vector<Known>& known, double angle, const std::vector<double>&) {
  const Known *before = nullptr, *after = nullptr;
  double back = 0, on = 0;
  for (const auto& k : known) {
    double ahead = std::fmod(k.angle - angle, pi);
    if (ahead < 0) ahead += pi;
    if (after == nullptr || ahead < on) on = ahead, after = &k;
    if (before == nullptr || pi - ahead < back) back = pi - ahead, before = &k;
  }
  const double share = back + on > 0 ? back / (back + on) : 0;
  return (1 - share) * before->log_bounce + share * after->log_bounce;
}

double harmonic_rule(const std::vector<Known>& known, double angle, const std::vector<double>&) {
  const Eigen::Index columns = known.size() >= 10 ? 5 : 3;
  const auto row = [&](double theta) {
    Eigen::VectorXd r(5);
    r << 1, std::cos(2 * theta), std::sin(2 * theta), std::cos(4 * theta), std::sin(4 * theta);
    return Eigen::VectorXd(r.head(columns));
  };
  Eigen::MatrixXd a(static_cast<Eigen::Index>(known.size()), columns);
  for (std::size_t k = 0; k < known.size(); ++k) a.row(static_cast<Eigen::Index>(k)) = row(known[k].angle);
  return fitted(a, bounces_of(known), row(angle), 0);
}

double feature_rule(const std::vector<Known>& known, double, const std::vector<double>& features) {
  const auto n = static_cast<Eigen::Index>(known.size());
  const auto m = static_cast<Eigen::Index>(features.size());
  Eigen::MatrixXd a(n, m + 1);
  Eigen::VectorXd at(m + 1);
  a.col(0).setOnes();
  at[0] = 1;
  for (Eigen::Index c = 0; c < m; ++c) {
    const auto f = static_cast<std::size_t>(c);
    for (Eigen::Index k = 0; k < n; ++k) a(k, c + 1) = known[static_cast<std::size_t>(k)].features[f];
    const double mean = a.col(c + 1).mean();
    const double deviation =
        std::sqrt((a.col(c + 1).array() - mean).square().mean()) + 1e-9 * std::fabs(mean) + 1e-30;
    a.col(c + 1).array() = (a.col(c + 1).array() - mean) / deviation;
    constexpr double furthest = 3;  // deviations: no line is trusted beyond
    at[c + 1] = std::clamp((features[f] - mean) / deviation, -furthest, furthest);
  }
  return fitted(a, bounces_of(known), at, 1);
}

Blend blended(const std::vector<Known>& known, const std::vector<double>& model, double angle,
              double model_at) {
  constexpr double lengths[] = {0.1, 0.3, 1, 3}, scatters[] = {0.03, 0.1, 0.3, 1, 3}, shares[] = {0, 0.5, 1};
  constexpr double expected = 0.2,
                   weight = 2;  // deviation of ln(bounce), and how many closings that is worth
  const std::size_t choices = model.empty() ? 1 : std::size(shares);
  const auto n = static_cast<Eigen::Index>(known.size());
  const auto correlation = [](double a, double b, double length) {
    return std::exp(-2 * std::fabs(std::sin(a - b)) / length);
  };
  const Eigen::VectorXd measured = bounces_of(known), ones = Eigen::VectorXd::Ones(n);
  struct Part {
    double evidence, value, variance, share;
  };
  std::vector<Part> parts;
  double most = -1e300;
  for (const double length : lengths)
    for (const double scatter : scatters) {
      Eigen::MatrixXd c(n, n);
      Eigen::VectorXd at(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        const double here = known[static_cast<std::size_t>(i)].angle;
        at[i] = correlation(here, angle, length);
        for (Eigen::Index k = 0; k < n; ++k)
          c(i, k) = correlation(here, known[static_cast<std::size_t>(k)].angle, length) + (i == k) * scatter;
      }
      const Eigen::LLT<Eigen::MatrixXd> llt(c);
      const Eigen::VectorXd of_ones = llt.solve(ones), of_at = llt.solve(at);
      const double precision = ones.dot(of_ones);
      const double log_volume = llt.matrixLLT().diagonal().array().log().sum() + 0.5 * std::log(precision);
      for (std::size_t k = 0; k < choices; ++k) {
        Eigen::VectorXd y = measured;
        for (Eigen::Index i = 0; i < n && !model.empty(); ++i)
          y[i] -= shares[k] * model[static_cast<std::size_t>(i)];
        const double mean = of_ones.dot(y) / precision;
        const Eigen::VectorXd left = y - mean * ones;
        const double squares = weight * expected * expected + left.dot(llt.solve(left));
        const double degrees = weight + static_cast<double>(n - 1);
        const double spread = 1 + scatter - at.dot(of_at) + std::pow(1 - ones.dot(of_at), 2) / precision;
        parts.push_back({-log_volume - 0.5 * degrees * std::log(squares),
                         mean + of_at.dot(left) + (model.empty() ? 0 : shares[k] * model_at),
                         squares / degrees * spread, shares[k]});
        most = std::max(most, parts.back().evidence);
      }
    }
  Blend b;
  double sum = 0, squares = 0;
  for (const auto& p : parts) {
    const double w = std::exp(p.evidence - most);
    sum += w;
    b.log_bounce += w * p.value;
    b.share += w * p.share;
    squares += w * (p.variance + p.value * p.value);
  }
  b.log_bounce /= sum;
  b.share /= sum;
  b.deviation = std::sqrt(std::max(0.0, squares / sum - b.log_bounce * b.log_bounce));
  return b;
}

}  // namespace powbench::bench
