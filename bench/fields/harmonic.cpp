#include "bench/fields/harmonic.h"

#include <cmath>
#include <stdexcept>

#include "core/units.h"

namespace powbench::bench {

using namespace sim;
namespace {

using Reals = std::vector<double>;

double norm(const Reals& a, const Reals& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * a[k] + b[k] * b[k];
  return std::sqrt(sum);
}

}  // namespace

Harmonic::Harmonic(const FieldProblem& problem, double hertz)
    : problem_(problem),
      omega_(2 * pi * hertz),
      stiffness_(problem.linear()),
      cholesky_(problem.space().pattern) {
  if (problem.mass().empty()) throw std::invalid_argument("field at one frequency: no region conducts");
  const Reals zero(static_cast<std::size_t>(problem.size()) + 1, 0);
  Reals gradient(zero);
  problem.add_steel(zero.data(), gradient.data(), stiffness_.data());
  Reals sum(stiffness_);
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += omega_ * problem.mass()[k];
  if (!cholesky_.factor(sum.data())) throw std::invalid_argument("field at one frequency: nothing fixes A");
}

std::vector<std::complex<double>> Harmonic::solve(const std::vector<std::complex<double>>& load) const {
  constexpr int most = 60;
  constexpr double enough = 1e-8, damping = 4.0 / 3;
  const auto& pattern = problem_.space().pattern;
  const std::size_t n = static_cast<std::size_t>(pattern.size);
  Reals u(n + 1, 0), v(n + 1, 0), p(n + 1), q(n + 1), au(n + 1), av(n + 1), bu(n + 1), bv(n + 1), sum(n + 1),
      x(n + 1);
  double wanted = -1;
  for (int step = 0; step < most; ++step) {
    multiply(pattern, stiffness_, u.data(), au.data());
    multiply(pattern, stiffness_, v.data(), av.data());
    multiply(pattern, problem_.mass(), u.data(), bu.data());
    multiply(pattern, problem_.mass(), v.data(), bv.data());
    for (std::size_t k = 0; k < n; ++k) {
      p[k] = load[k].real() - au[k] + omega_ * bv[k];
      q[k] = load[k].imag() - av[k] - omega_ * bu[k];
      sum[k] = p[k] + q[k];
    }
    const double rest = norm(p, q);
    if (wanted < 0) wanted = enough * rest;
    if (rest <= wanted) {
      std::vector<std::complex<double>> a(n + 1);
      for (std::size_t k = 0; k < n; ++k) a[k] = {u[k], v[k]};
      return a;
    }
    cholesky_.solve(sum.data());
    multiply(pattern, problem_.mass(), sum.data(), x.data());
    for (std::size_t k = 0; k < n; ++k) x[k] = p[k] + omega_ * x[k];
    cholesky_.solve(x.data());
    for (std::size_t k = 0; k < n; ++k) {
      u[k] += damping * x[k];
      v[k] += damping * (sum[k] - x[k]);
    }
  }
  throw std::runtime_error("field at one frequency: no convergence");
}

std::vector<std::complex<double>> Harmonic::mass_times(const std::vector<std::complex<double>>& a) const {
  const auto& pattern = problem_.space().pattern;
  Reals u(a.size()), v(a.size()), mu(a.size()), mv(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    u[k] = a[k].real();
    v[k] = a[k].imag();
  }
  multiply(pattern, problem_.mass(), u.data(), mu.data());
  multiply(pattern, problem_.mass(), v.data(), mv.data());
  std::vector<std::complex<double>> m(a.size());
  for (std::size_t k = 0; k + 1 < a.size(); ++k) m[k] = {mu[k], mv[k]};
  return m;
}

}  // namespace powbench::bench
