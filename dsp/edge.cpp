#include "dsp/edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dsp/least_squares.h"

namespace powbench::dsp {

namespace {

constexpr int terms = 3, unknowns = terms + 1;
constexpr std::array<double, 7> laws{0, 0.75, 1, 1.25, 1.5, 1.75, 2};
constexpr std::array<double, 7> before_data{0.3, 0.3, 1,  1,
                                            1,   0.3, 0.1};  // weights: most pads are springs or round
constexpr double largest_term = 3;  // standard deviation of a term over the largest force in sight
constexpr double zero_error = 2;    // of the open level, over the noise
constexpr double backwards = 8;     // taken off the log of a law that begins by pulling
constexpr double negligible = 16;   // e^-16 of the best counts no more
constexpr double shrink = 0.6;      // of the span, from one look to the next
constexpr std::size_t most_rows = 96, least_rows = 6;

/// Means of `per_row` samples; time runs into the contact from the guess on.
struct Rows {
  std::vector<double> t, y;  // s, in units of the row's noise
  double step = 0, noise = 0, top = 0;
  std::size_t closed = 0;
};

Rows rows_of(const Signal& s, const EdgeQuestion& q, double span) {
  Rows r;
  const double dt = s.dt;
  const auto per_row = std::max<std::size_t>(1, static_cast<std::size_t>(span / dt / most_rows));
  r.step = static_cast<double>(per_row) * dt;
  r.noise = q.noise / std::sqrt(static_cast<double>(per_row));
  const double t1 = q.side > 0 ? q.near - q.open : q.near - span,
               t2 = q.side > 0 ? q.near + span : q.near + q.open;
  const std::size_t i1 = s.index_at(t1), i2 = std::min(s.index_at(t2) + 1, s.size());
  const auto take = [&](std::size_t first) {
    double sum = 0;
    std::uint8_t mask = 0;
    for (std::size_t i = first; i < first + per_row; ++i) sum += s.value[i], mask |= s.masked[i];
    const double mean = sum / static_cast<double>(per_row);
    const double t = q.side * (s.time(first) + 0.5 * (r.step - dt) - q.near);
    if (mask != mask_none) return t < 0;  // what is lost before the edge is only left out
    r.t.push_back(t);
    r.y.push_back(mean / r.noise);
    r.top = std::max(r.top, mean);
    r.closed += t > 0;
    return true;
  };
  if (q.side > 0) {
    for (std::size_t i = i1; i + per_row <= i2; i += per_row)
      if (!take(i)) break;
  } else {
    for (std::size_t i = i2; i >= i1 + per_row; i -= per_row)
      if (!take(i - per_row)) break;
  }
  r.top = std::max(r.top, 6 * r.noise);
  return r;
}

struct Evidence {
  double log = -std::numeric_limits<double>::infinity();
  double chi2 = 0;
};

/// Sums of one law: powers tau^(2 q + m), tau^(q + k), and y tau^(q + k).
struct Sums {
  std::array<double, 2 * terms - 1> square{};
  std::array<double, terms> plain{}, data{};
};

/// log of the evidence of a law with everything linear integrated out, up to a constant of the data.
Evidence evidence_of(const Sums& s, double n, double y, double yy, double scale, double zero, bool may_pull) {
  std::array<std::array<double, unknowns>, unknowns> m{};
  std::array<double, unknowns> b{};
  for (int j = 0; j < terms; ++j) {
    for (int k = 0; k <= j; ++k) m[j][k] = scale * scale * s.square[j + k] + (j == k ? 1.0 : 0.0);
    m[terms][j] = scale * zero * s.plain[j];
    b[j] = scale * s.data[j];
  }
  m[terms][terms] = zero * zero * n + 1;
  b[terms] = zero * y;
  const auto gram = m;
  double log_det = 0, gain = 0;
  std::array<double, unknowns> z{};
  for (int j = 0; j < unknowns; ++j) {  // Cholesky, forward substitution along the way
    for (int k = 0; k < j; ++k) {
      for (int i = 0; i < k; ++i) m[j][k] -= m[j][i] * m[k][i];
      m[j][k] /= m[k][k];
    }
    for (int i = 0; i < j; ++i) m[j][j] -= m[j][i] * m[j][i];
    m[j][j] = std::sqrt(m[j][j]);
    z[j] = b[j];
    for (int i = 0; i < j; ++i) z[j] -= m[j][i] * z[i];
    z[j] /= m[j][j];
    log_det += std::log(m[j][j]);
    gain += z[j] * z[j];
  }
  std::array<double, unknowns> x{};
  for (int j = unknowns; j-- > 0;) {
    x[j] = z[j];
    for (int i = j + 1; i < unknowns; ++i) x[j] -= m[i][j] * x[i];
    x[j] /= m[j][j];
  }
  double left = yy;  // |y - X x|^2 without the priors
  for (int j = 0; j < unknowns; ++j) {
    left -= 2 * x[j] * b[j];
    for (int k = 0; k < unknowns; ++k)
      left += x[j] * x[k] * (gram[std::max(j, k)][std::min(j, k)] - (j == k ? 1.0 : 0.0));
  }
  return {0.5 * gain - log_det - (x[0] < 0 && !may_pull ? backwards : 0.0), left};
}

/// Of all laws with the edge at `t0`: log of the summed evidence, and what the best one leaves.
Evidence evidence_at(const Rows& r, double t0, double span, bool breaks) {
  std::array<Sums, laws.size()> sums{};
  double y = 0, yy = 0;
  for (std::size_t i = 0; i < r.t.size(); ++i) {
    const double v = r.y[i];
    y += v, yy += v * v;
    const double tau = (r.t[i] - t0) / span;
    if (tau <= 0) continue;
    const double half = std::sqrt(tau), quarter = std::sqrt(half);
    const std::array<double, laws.size()> power{1,          half * quarter,       tau,      tau * quarter,
                                                tau * half, tau * half * quarter, tau * tau};
    for (std::size_t l = 0; l < laws.size(); ++l) {
      Sums& s = sums[l];
      double p = power[l], square = p * p;
      for (double& sum : s.square) sum += square, square *= tau;
      for (int k = 0; k < terms; ++k, p *= tau) s.plain[k] += p, s.data[k] += v * p;
    }
  }
  Evidence best;
  std::array<double, laws.size()> logs{};
  for (std::size_t l = 0; l < laws.size(); ++l) {
    const Evidence e = evidence_of(sums[l], static_cast<double>(r.t.size()), y, yy,
                                   largest_term * r.top / r.noise, zero_error, breaks && laws[l] == 0);
    logs[l] = e.log + std::log(before_data[l]);
    if (logs[l] > best.log) best = {logs[l], e.chi2};
  }
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - best.log);
  best.log += std::log(sum);
  return best;
}

struct Posterior {
  double mean = 0, sigma = 0, chi2 = 0;
};

/// Mean and deviation of t0 over [from, to], the grid drawn together around what counts.
Posterior posterior_of(const Rows& r, double from, double to, double span, bool breaks) {
  Posterior p;
  auto nodes = std::clamp<std::size_t>(static_cast<std::size_t>(2 * (to - from) / r.step), 24, 160);
  for (int pass = 0; pass < 3; ++pass, nodes = 32) {
    const double step = (to - from) / static_cast<double>(nodes);
    std::vector<Evidence> at(nodes + 1);
    std::size_t best = 0;
    for (std::size_t k = 0; k <= nodes; ++k) {
      at[k] = evidence_at(r, from + static_cast<double>(k) * step, span, breaks);
      if (at[k].log > at[best].log) best = k;
    }
    double weight = 0, sum = 0, squares = 0;
    std::size_t first = nodes, last = 0;
    for (std::size_t k = 0; k <= nodes; ++k) {
      const double below = at[best].log - at[k].log;
      if (below > negligible) continue;
      first = std::min(first, k), last = std::max(last, k);
      const double w = std::exp(-below), t = static_cast<double>(k) * step;
      weight += w, sum += w * t, squares += w * t * t;
    }
    const double mean = sum / weight;
    p = {from + mean, std::sqrt(std::max(squares / weight - mean * mean, step * step / 12)), at[best].chi2};
    to = from + step * static_cast<double>(std::min(last + 1, nodes));
    from += step * (first > 0 ? static_cast<double>(first - 1) : 0.0);
    if (static_cast<double>(last - first) > 0.8 * static_cast<double>(nodes) && pass > 0) break;
  }
  return p;
}

}  // namespace

namespace {

/// The edge with the force up to `span` from it.
EdgeAnswer within(const Signal& s, const EdgeQuestion& q, double span) {
  EdgeAnswer out;
  const Rows r = rows_of(s, q, span);
  if (r.closed < least_rows || r.t.size() < least_rows + 3) return out;
  out.span = *std::max_element(r.t.begin(), r.t.end());
  const Posterior p = posterior_of(r, -0.6 * q.open, 0.6 * out.span, out.span, q.side < 0);
  const double dof = std::max(1.0, static_cast<double>(r.t.size()) - unknowns - 1);
  out.known = true;
  out.reduced_chi2 = p.chi2 / dof;
  out.followed = out.reduced_chi2 < 1 + 3 * std::sqrt(2 / dof);
  out.time = {q.near + q.side * p.mean, std::hypot(p.sigma, s.dt / 12)};
  return out;
}

}  // namespace

EdgeAnswer locate_edge(const Signal& s, const EdgeQuestion& q) {
  const double shortest = 8 * s.dt;
  double span = std::max(q.closed, shortest);
  EdgeAnswer wide = within(s, q, span);
  // A span that the laws follow only nearly moves the edge by more than it admits: a shorter one must agree.
  while (wide.known && shrink * span >= shortest) {
    span *= shrink;
    const EdgeAnswer narrow = within(s, q, span);
    if (!narrow.known) break;
    const double apart = std::abs(narrow.time.value - wide.time.value);
    const double allowed =
        std::sqrt(std::max(narrow.time.u * narrow.time.u - wide.time.u * wide.time.u, 0.0));
    if (wide.followed && apart <= 1.5 * std::max(allowed, 0.5 * wide.time.u)) {
      wide.time.u = std::hypot(wide.time.u, 0.5 * apart);
      return wide;
    }
    wide = narrow;
  }
  if (!wide.known || wide.followed) return wide;
  EdgeQuestion noisier = q;  // no part of the edge follows any law: the misfit counts as noise
  noisier.noise *= std::sqrt(wide.reduced_chi2);
  const double misfit = wide.reduced_chi2;
  wide = within(s, noisier, span);
  wide.followed = false;
  wide.reduced_chi2 = misfit;
  return wide;
}

namespace {

constexpr std::size_t order = 5;  // coefficients of the polynomial through an extreme

struct Polynomial {
  bool known = false;
  double reduced_chi2 = 0;
  Measured most;  ///< largest value on the samples, times `side`
};

/// Fitted to samples a .. b - 1, with time in units of `half` from sample `at`.
Polynomial polynomial_through(const Signal& s, std::size_t a, std::size_t b, std::size_t at, double half,
                              int side, double noise) {
  Polynomial out;
  std::vector<std::vector<double>> columns(order);
  std::vector<double> y;
  const auto x_of = [&](std::size_t i) { return (s.time(i) - s.time(at)) / half; };
  for (std::size_t i = a; i < b; ++i) {
    if (s.masked[i]) continue;
    double p = 1;
    for (auto& c : columns) c.push_back(p / noise), p *= x_of(i);
    y.push_back(side * s.value[i] / noise);
  }
  if (y.size() < order + 1) return out;
  const LeastSquares fit = linear_least_squares(columns, y);
  out.known = true;
  out.reduced_chi2 = fit.chi2 / static_cast<double>(y.size() - order);
  out.most = {-1e300, 0};
  for (std::size_t i = a; i < b; ++i) {
    double p = 1, v = 0, variance = 0;
    std::array<double, order> powers{};
    for (std::size_t k = 0; k < order; ++k, p *= x_of(i)) powers[k] = p, v += p * fit.x[k];
    if (v <= out.most.value) continue;
    for (std::size_t j = 0; j < order; ++j)
      for (std::size_t k = 0; k < order; ++k)
        variance += powers[j] * powers[k] * fit.covariance[j * order + k];
    out.most = {v, std::sqrt(std::max(variance, 0.0))};
  }
  return out;
}

bool follows(const Polynomial& p, std::size_t samples) {
  const double dof = std::max(1.0, static_cast<double>(samples) - static_cast<double>(order));
  return p.reduced_chi2 < 1 + 2 * std::sqrt(2 / dof);
}

}  // namespace

Measured locate_extreme(const Signal& s, double from, double to, int side, double noise) {
  const std::size_t i1 = s.index_at(from), i2 = std::min(s.index_at(to), s.size());
  if (i2 < i1 + order + 1) return {};
  const std::size_t smooth = std::max<std::size_t>(1, (i2 - i1) / 24);
  double top = -1e300, sum = 0;
  std::size_t at = i1;
  for (std::size_t i = i1; i < i2; ++i) {
    sum += side * (s.value[i] - (i >= i1 + smooth ? s.value[i - smooth] : 0.0));
    if (i + 1 < i1 + smooth) continue;
    if (sum > top) top = sum, at = i - smooth / 2;
  }
  Measured before;
  bool followed = false;
  for (double half = 0.3 * (to - from);; half *= 0.7) {
    const auto reach = static_cast<std::size_t>(half / s.dt);
    const std::size_t a = at > i1 + reach ? at - reach : i1, b = std::min(at + reach + 1, i2);
    if (b < a + order + 1) return before;
    const Polynomial p = polynomial_through(s, a, b, at, half, side, noise);
    if (!p.known) return before;
    Measured now{side * p.most.value, p.most.u};
    // what the next narrower one says differently was not followed, only hidden by the noise
    const double apart = before.known() ? now.value - before.value : 0.0;
    if (followed) return {before.value, std::hypot(before.u, 0.7 * apart)};
    followed = follows(p, b - a);
    if (!followed) now.u = std::hypot(now.u * std::sqrt(p.reduced_chi2), 0.5 * apart);
    before = now;
  }
}

}  // namespace powbench::dsp
