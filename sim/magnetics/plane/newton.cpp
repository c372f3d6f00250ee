#include "sim/magnetics/plane/newton.h"

#include <algorithm>
#include <cmath>

#include "sim/dot.h"

namespace powbench::sim {
namespace {

double absolute_dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 1e-300;
  for (std::size_t k = 0; k < a.size(); ++k) sum += std::fabs(a[k] * b[k]);
  return sum;
}

}  // namespace

std::vector<double> inverse_of(std::vector<double> m, std::size_t n) {
  std::vector<double> inverse(n * n, 0);
  for (std::size_t k = 0; k < n; ++k) inverse[k * n + k] = 1;
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = 1 / m[k * n + k];
    for (std::size_t j = 0; j < n; ++j) {
      m[k * n + j] *= pivot;
      inverse[k * n + j] *= pivot;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = m[i * n + k];
      for (std::size_t j = 0; j < n; ++j) {
        m[i * n + j] -= factor * m[k * n + j];
        inverse[i * n + j] -= factor * inverse[k * n + j];
      }
    }
  }
  return inverse;
}

struct Newton::Step {
  std::vector<double> da;
  std::vector<double> di;  ///< by winding; 0 where the current is given
  double miss = 0;         ///< largest |b - c^T a - r i| / |b| before the step
};

Newton::Newton(const FieldProblem& problem) : problem_(problem), cholesky_(problem.space().pattern) {
  const auto size = static_cast<std::size_t>(problem.size());
  values_.resize(problem.space().pattern.row.size() + 1);
  gradient_.resize(size + 1);
  cholesky_.set_changing(problem.steel_unknowns());
}

void Newton::set_quadratic(const std::vector<double>* matrix, const std::vector<double>* load) {
  matrix_ = matrix;
  load_ = load;
}

/// Energy without windings, its gradient, and the Hessian.
double Newton::evaluate(const std::vector<double>& a, bool hessian) {
  const auto& linear = matrix_ ? *matrix_ : problem_.linear();
  multiply(problem_.space().pattern, linear, a.data(), gradient_.data());
  gradient_.back() = 0;
  quadratic_ = 0.5 * dot(a, gradient_);
  if (load_) {
    quadratic_ -= dot(*load_, a);
    for (std::size_t k = 0; k + 1 < a.size(); ++k) gradient_[k] -= (*load_)[k];
  }
  if (hessian) values_ = linear;
  const double steel = problem_.add_steel(a.data(), gradient_.data(), hessian ? values_.data() : nullptr);
  gradient_.back() = 0;
  return quadratic_ + steel;
}

bool Newton::direction(const std::vector<Circuit>& circuits, const std::vector<double>& a,
                       const std::vector<double>& current, Step& step) {
  const bool kept = !matrix_ && factored_version_ == problem_.linear_version();
  factored_version_ = matrix_ ? -1 : problem_.linear_version();
  if (!cholesky_.factor(values_.data(), kept)) return false;
  bordered_.clear();
  step.da.assign(a.size(), 0);
  step.di.assign(circuits.size(), 0);
  step.miss = 0;
  for (std::size_t k = 0; k < a.size(); ++k) step.da[k] = -gradient_[k];
  for (std::size_t c = 0; c < circuits.size(); ++c) {
    const auto& w = problem_.winding(c);
    for (std::size_t k = 0; k + 1 < a.size(); ++k) step.da[k] += current[c] * w[k];
    if (circuits[c].flux_given) bordered_.push_back(c);
  }
  const std::size_t n = bordered_.size();
  border_.resize(n);
  std::vector<double> schur(n * n), rest(n);
  std::vector<double*> sides{step.da.data()};
  for (std::size_t k = 0; k < n; ++k) {
    border_[k] = problem_.winding(bordered_[k]);
    sides.push_back(border_[k].data());
  }
  cholesky_.solve(sides);
  for (std::size_t k = 0; k < n; ++k) {
    const auto& w = problem_.winding(bordered_[k]);
    const auto& circuit = circuits[bordered_[k]];
    const double missing = circuit.value - dot(w, a) - circuit.resistance * current[bordered_[k]];
    step.miss =
        std::max(step.miss, std::fabs(missing) / std::max(std::fabs(circuit.value), absolute_dot(w, a)));
    rest[k] = missing - dot(w, step.da);
    for (std::size_t l = 0; l < n; ++l)
      schur[k * n + l] = dot(w, border_[l]) + (k == l ? circuit.resistance : 0);
  }
  inverse_ = inverse_of(schur, n);
  for (std::size_t k = 0; k < n; ++k) {
    double di = 0;
    for (std::size_t l = 0; l < n; ++l) di += inverse_[k * n + l] * rest[l];
    step.di[bordered_[k]] = di;
    for (std::size_t j = 0; j < a.size(); ++j) step.da[j] += di * border_[k][j];
  }
  step.da.back() = 0;
  return true;
}

double LineSearch::share(const std::vector<double>& a, const std::vector<double>& da,
                         const std::vector<double>& current, const std::vector<double>& di, double decrement,
                         double quadratic, int& cuts) const {
  constexpr double enough = 1e-4, least = 1e-6;
  const FieldProblem::Ray ray(problem, a.data(), da.data());
  std::vector<double> product(a.size());
  multiply(problem.space().pattern, matrix, da.data(), product.data());
  product.back() = 0;
  double slope = dot(a, product), bend = dot(da, product);
  if (load) slope -= dot(*load, da);
  for (std::size_t c = 0; c < circuits.size(); ++c) {
    const double r = circuits[c].resistance;
    if (!circuits[c].flux_given) slope -= circuits[c].value * dot(problem.winding(c), da);
    slope += r * current[c] * di[c];
    bend += r * di[c] * di[c];
  }
  const double start = ray.steel_energy(0);
  double s = 1;
  for (; s > least; s *= 0.5) {
    const double change = ray.steel_energy(s) - start + s * (slope + 0.5 * s * bend);
    if (change <= -enough * s * decrement + 1e-14 * (std::fabs(quadratic) + start)) break;
    ++cuts;
  }
  return s;
}

NewtonReport Newton::solve(const std::vector<Circuit>& circuits, std::vector<double>& a,
                           std::vector<double>& current, const NewtonOptions& options) {
  constexpr double met = 1e-8;  // circuits count as met
  NewtonReport report;
  Step step;
  const LineSearch line{problem_, matrix_ ? *matrix_ : problem_.linear(), load_, circuits};
  current.resize(circuits.size(), 0);
  for (std::size_t c = 0; c < circuits.size(); ++c)
    if (!circuits[c].flux_given) current[c] = circuits[c].value;
  energy_ = evaluate(a, true);
  while (report.iterations < options.most_iterations) {
    if (!direction(circuits, a, current, step)) return report;
    ++report.iterations;
    // lambda^2 = da^T H da = -(gradient - C i)^T da on what the circuits leave free
    double decrement = -dot(gradient_, step.da);
    for (std::size_t c = 0; c < circuits.size(); ++c)
      decrement +=
          (current[c] + (circuits[c].flux_given ? step.di[c] : 0)) * dot(problem_.winding(c), step.da);
    decrement = std::fabs(decrement);
    const bool feasible = step.miss < met;
    const double s = options.line_search && feasible && decrement > options.tolerance * energy_
                         ? line.share(a, step.da, current, step.di, decrement, quadratic_, report.cuts)
                         : 1.0;
    for (std::size_t k = 0; k < a.size(); ++k) a[k] += s * step.da[k];
    for (std::size_t c = 0; c < circuits.size(); ++c) current[c] += s * step.di[c];
    const bool last = feasible && decrement <= options.tolerance * std::fabs(energy_);
    energy_ = evaluate(a, !last);
    report.decrement = decrement / std::max(std::fabs(energy_), 1e-300);
    if (last || energy_ == 0) {
      report.converged = true;
      return report;
    }
  }
  return report;
}

double Newton::gap_gap(const std::vector<double>& a) const {
  if (problem_.setup().strip_region < 0) return 0;
  const std::size_t n = bordered_.size();
  std::vector<double> force(a.size());
  problem_.gap_gradient(a.data(), force.data());
  auto moved = force;
  cholesky_.solve(moved.data());
  moved.back() = 0;
  double sum = problem_.gap_curvature(a.data()) - dot(force, moved);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t l = 0; l < n; ++l)
      sum += inverse_[k * n + l] * dot(problem_.winding(bordered_[l]), moved) * dot(force, border_[k]);
  return sum;
}

std::vector<double> Newton::flux_tangent(std::size_t k) const {
  const std::size_t n = bordered_.size();
  std::vector<double> tangent(border_.front().size(), 0);
  for (std::size_t l = 0; l < n; ++l)
    for (std::size_t j = 0; j < tangent.size(); ++j) tangent[j] += inverse_[l * n + k] * border_[l][j];
  return tangent;
}

}  // namespace powbench::sim
