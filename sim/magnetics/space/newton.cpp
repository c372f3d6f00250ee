#include "sim/magnetics/space/newton.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "sim/dot.h"

namespace powbench::sim::space {
namespace {

/// Solves the small dense symmetric positive definite system by Gauss.
std::vector<double> solve_dense(std::vector<double> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double f = a[i * n + k] / a[k * n + k];
      for (std::size_t j = k; j < n; ++j) a[i * n + j] -= f * a[k * n + j];
      b[i] -= f * b[k];
    }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k * n + j] * b[j];
    b[k] /= a[k * n + k];
  }
  return b;
}

}  // namespace

/// The function along a line: value and slope of W' - psi I.
struct Newton::Step {
  std::vector<double> gradient, flux;
  double coenergy = 0, value = 0;
};

struct Newton::Impl {
  const Coenergy& function;
  Coenergy::Hessian hessian;
  Cholesky factor;
  std::vector<Drive> drive;

  explicit Impl(const Coenergy& f) : function(f), hessian(f.hessian()), factor(hessian.uu) {}

  Step evaluate(const State& s) const {
    Step p;
    p.coenergy = p.value = function.value(s, &p.gradient, &p.flux);
    for (std::size_t k = 0; k < drive.size(); ++k)
      if (drive[k].flux) p.value -= drive[k].value * s.current[k];
    return p;
  }

  /// Slope of the function along a direction.
  double slope(const Step& p, const State& direction) const {
    double sum = dot(p.gradient, direction.u);
    for (std::size_t k = 0; k < drive.size(); ++k)
      if (drive[k].flux) sum += (p.flux[k] - drive[k].value) * direction.current[k];
    return sum;
  }

  State newton_direction(const State& s, const Step& p);
  double line_search(State& s, Step& p, const State& direction, double first_slope, int& extra) const;
};

State Newton::Impl::newton_direction(const State& s, const Step& p) {
  function.hessian(s, hessian);
  if (!factor.factor(hessian.uu))
    throw std::logic_error("field in space: the matrix of a convex energy lost its sign");
  std::vector<std::size_t> free;  // windings whose current is unknown
  for (std::size_t k = 0; k < drive.size(); ++k)
    if (drive[k].flux) free.push_back(k);
  std::vector<double> right(p.gradient);
  for (double& r : right) r = -r;
  for (const auto k : free) right.insert(right.end(), hessian.ui[k].begin(), hessian.ui[k].end());
  const auto x = factor.solve(right);
  const std::size_t n = p.gradient.size(), m = free.size(), windings = drive.size();
  State d{{x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n)}, std::vector<double>(windings, 0)};
  if (m == 0) return d;
  std::vector<double> schur(m * m), residual(m);
  for (std::size_t a = 0; a < m; ++a) {
    const auto& column = hessian.ui[free[a]];
    residual[a] = drive[free[a]].value - p.flux[free[a]] - dot(column, d.u);
    for (std::size_t b = 0; b < m; ++b) {
      double sum = hessian.ii[free[a] * windings + free[b]];
      for (std::size_t i = 0; i < n; ++i) sum -= column[i] * x[(b + 1) * n + i];
      schur[a * m + b] = sum;
    }
  }
  const auto current = solve_dense(schur, residual);
  for (std::size_t b = 0; b < m; ++b) {
    d.current[free[b]] = current[b];
    for (std::size_t i = 0; i < n; ++i) d.u[i] -= current[b] * x[(b + 1) * n + i];
  }
  return d;
}

/// Factoring costs a hundred times more than looking along the line, so the line is searched until the slope has lost
/// nine tenths: further than the full step when it still falls, and back by the secant of the slope when it rises.
double Newton::Impl::line_search(State& s, Step& p, const State& d, double first_slope, int& extra) const {
  const auto moved = [&](double t) {
    State next = s;
    for (std::size_t i = 0; i < next.u.size(); ++i) next.u[i] += t * d.u[i];
    for (std::size_t k = 0; k < next.current.size(); ++k) next.current[k] += t * d.current[k];
    return next;
  };
  double low = 0, high = 0, low_slope = first_slope, high_slope = 0, t = 1;
  for (int k = 0;; ++k) {
    State next = moved(t);
    Step at = evaluate(next);
    const double here = slope(at, d);
    if (std::fabs(here) <= 0.1 * std::fabs(first_slope) || k == 12) {
      s = std::move(next);
      p = std::move(at);
      return t;
    }
    ++extra;
    if (here < 0) {
      low = t;
      low_slope = here;
    } else {
      high = t;
      high_slope = here;
    }
    if (high == 0) {
      t *= 2;
    } else {
      const double secant = low + (high - low) * low_slope / (low_slope - high_slope);
      const double margin = 0.1 * (high - low);  // so that the bracket shrinks from both ends
      t = std::clamp(secant, low + margin, high - margin);
    }
  }
}

Newton::Newton(const Coenergy& function) : impl_(std::make_unique<Impl>(function)) {}
Newton::~Newton() = default;

Solution Newton::solve(const std::vector<Drive>& drive, const State& start, const NewtonOptions& options) {
  assert(static_cast<int>(drive.size()) == impl_->function.windings());
  impl_->drive = drive;
  Solution out;
  State& s = out.state;
  s = start;
  s.u.resize(static_cast<std::size_t>(impl_->function.unknowns()), 0);
  s.current.resize(drive.size(), 0);
  for (std::size_t k = 0; k < drive.size(); ++k) {
    if (!std::isfinite(drive[k].value))
      throw std::invalid_argument("field in space: the drive of a winding is not a finite number");
    if (!drive[k].flux) s.current[k] = drive[k].value;
  }
  Step p = impl_->evaluate(s);
  while (out.iterations < options.most_iterations) {
    const State d = impl_->newton_direction(s, p);
    const double slope = impl_->slope(p, d);
    out.decrement = p.coenergy > 0 ? -slope / p.coenergy : -slope;
    if (p.coenergy > 0 && -slope <= options.tolerance * p.coenergy) out.converged = true;
    if (slope == 0) out.converged = true;
    if (out.converged && -slope <= 1e-22 * p.coenergy) break;
    ++out.iterations;
    if (out.converged) {  // the step is there already; it squares the error
      for (std::size_t i = 0; i < s.u.size(); ++i) s.u[i] += d.u[i];
      for (std::size_t k = 0; k < s.current.size(); ++k) s.current[k] += d.current[k];
      p = impl_->evaluate(s);
      break;
    }
    impl_->line_search(s, p, d, slope, out.line_steps);
  }
  out.flux = p.flux;
  out.coenergy = p.coenergy;
  out.energy = dot(p.flux, s.current) - p.coenergy;
  return out;
}

std::vector<std::vector<double>> Newton::tangents(const State& s, std::vector<double>& inductance,
                                                  bool factored) {
  auto& h = impl_->hessian;
  if (!factored) {
    impl_->function.hessian(s, h);
    if (!impl_->factor.factor(h.uu))
      throw std::logic_error("field in space: the matrix of a convex energy lost its sign");
  }
  const std::size_t m = h.ui.size();
  std::vector<std::vector<double>> out;
  inductance = h.ii;
  for (std::size_t k = 0; k < m; ++k) {
    out.push_back(impl_->factor.solve(h.ui[k]));
    for (double& x : out.back()) x = -x;
    for (std::size_t l = 0; l < m; ++l) inductance[l * m + k] += dot(h.ui[l], out.back());
  }
  return out;
}

std::vector<double> Newton::inductance(const State& s) {
  std::vector<double> out;
  tangents(s, out);
  return out;
}

}  // namespace powbench::sim::space
