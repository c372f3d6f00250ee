#include "dsp/edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dsp/amplifier.h"

namespace powbench::dsp {

namespace {

constexpr int terms = 3, unknowns = terms + 1;
constexpr std::array<double, 7> laws{0, 0.75, 1, 1.25, 1.5, 1.75, 2};
/// log of the weights 0.3, 0.3, 1, 1, 1, 0.3, 0.1: most pads are springs or round
constexpr std::array<double, 7> log_before{-1.2039728043259361, -1.2039728043259361, 0, 0, 0,
                                           -1.2039728043259361, -2.3025850929940459};
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
  double delay = 0;  // s
  int side = +1;
};

Rows rows_of(const Signal& s, const EdgeQuestion& q, double span) {
  Rows r;
  r.delay = q.delay, r.side = q.side;
  const double dt = s.dt;
  const auto per_row = std::max<std::size_t>(1, static_cast<std::size_t>(span / dt / most_rows + 1e-6));
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
  double chi2 = 0;  ///< only where it was asked for
};

/// Sums of one law over the rows: products of its terms j >= k, the terms, and y times the terms.
struct Sums {
  std::array<std::array<double, terms>, terms> square{};
  std::array<double, terms> plain{}, data{};
};

/// What no edge time changes: rows, sum and sum of squares of the data.
struct Totals {
  double n = 0, y = 0, yy = 0;
};

Totals totals_of(const Rows& r) {
  Totals t{static_cast<double>(r.t.size()), 0, 0};
  for (const double v : r.y) t.y += v, t.yy += v * v;
  return t;
}

/// log of the evidence of a law with everything linear integrated out, up to a constant of the data.
Evidence evidence_of(const Sums& s, const Totals& all, double scale, double zero, bool may_pull,
                     bool with_chi2) {
  std::array<std::array<double, unknowns>, unknowns> m{};
  std::array<double, unknowns> b{};
  for (int j = 0; j < terms; ++j) {
    for (int k = 0; k <= j; ++k) m[j][k] = scale * scale * s.square[j][k] + (j == k ? 1.0 : 0.0);
    m[terms][j] = scale * zero * s.plain[j];
    b[j] = scale * s.data[j];
  }
  m[terms][terms] = zero * zero * all.n + 1;
  b[terms] = zero * all.y;
  const auto gram = m;
  double determinant = 1, gain = 0;
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
    determinant *= m[j][j];
    gain += z[j] * z[j];
  }
  std::array<double, unknowns> x{};
  for (int j = unknowns; j-- > 0;) {
    x[j] = z[j];
    for (int i = j + 1; i < unknowns; ++i) x[j] -= m[i][j] * x[i];
    x[j] /= m[j][j];
  }
  Evidence e{0.5 * gain - std::log(determinant) - (x[0] < 0 && !may_pull ? backwards : 0.0), 0};
  if (!with_chi2) return e;
  e.chi2 = all.yy;  // |y - X x|^2 without the priors
  for (int j = 0; j < unknowns; ++j) {
    e.chi2 -= 2 * x[j] * b[j];
    for (int k = 0; k < unknowns; ++k)
      e.chi2 += x[j] * x[k] * (gram[std::max(j, k)][std::min(j, k)] - (j == k ? 1.0 : 0.0));
  }
  return e;
}

/// Sums over the rows behind an edge that the laws share: powers of tau in steps of a half up to 8, and of a quarter
/// up to 4, the latter also times the data. Four rows at a time.
struct SharedSums {
  static constexpr std::size_t lanes = 4;
  using Lane = std::array<double, lanes>;
  std::array<double, 17> half{};
  std::array<double, 17> quarter{}, data{};
};

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
// without fused products, so that every version rounds alike
#define POWBENCH_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define POWBENCH_WIDE
#endif

POWBENCH_WIDE SharedSums shared_sums(const Rows& r, double t0, double span) {
  using Lane = SharedSums::Lane;
  constexpr std::size_t lanes = SharedSums::lanes;
  // whole powers 0 .. 8; and w^(1/2) .. : 1.5, 2.5, .. 7.5; 0.75 .. 3.75; 1.25 .. 3.25
  std::array<Lane, 9> whole{};
  std::array<Lane, 7> halves{};
  std::array<Lane, 4> three{};
  std::array<Lane, 3> five{};
  std::array<Lane, 5> y_whole{};
  std::array<Lane, 3> y_halves{}, y_five{};
  std::array<Lane, 4> y_three{};
  const auto first = static_cast<std::size_t>(
      std::partition_point(r.t.begin(), r.t.end(), [&](double t) { return !(t > t0); }) - r.t.begin());
  const double per = 1 / span;
  for (std::size_t i = first; i < r.t.size(); i += lanes) {
    Lane tau{}, v{}, one{};
    for (std::size_t l = 0; l < lanes && i + l < r.t.size(); ++l)
      tau[l] = (r.t[i + l] - t0) * per, v[l] = r.y[i + l], one[l] = 1;
    Lane root, fourth;
    for (std::size_t l = 0; l < lanes; ++l) root[l] = std::sqrt(tau[l]);
    for (std::size_t l = 0; l < lanes; ++l) fourth[l] = std::sqrt(root[l]);
    const auto run = [&](Lane p, auto& sums, auto& with_data) {
      for (std::size_t k = 0; k < sums.size(); ++k) {
        for (std::size_t l = 0; l < lanes; ++l) sums[k][l] += p[l];
        if (k < with_data.size())
          for (std::size_t l = 0; l < lanes; ++l) with_data[k][l] += v[l] * p[l];
        for (std::size_t l = 0; l < lanes; ++l) p[l] *= tau[l];
      }
    };
    Lane p15, p075, p125;
    for (std::size_t l = 0; l < lanes; ++l) {
      p15[l] = tau[l] * root[l];
      p075[l] = root[l] * fourth[l];
      p125[l] = tau[l] * fourth[l];
    }
    run(one, whole, y_whole);
    run(p15, halves, y_halves);
    run(p075, three, y_three);
    run(p125, five, y_five);
  }
  SharedSums s;
  const auto sum = [](const Lane& l) { return (l[0] + l[1]) + (l[2] + l[3]); };
  for (std::size_t k = 0; k < 9; ++k) s.half[2 * k] = sum(whole[k]);
  for (std::size_t k = 0; k < 7; ++k) s.half[2 * k + 3] = sum(halves[k]);
  for (std::size_t k = 0; k < 5; ++k) s.quarter[4 * k] = sum(whole[k]), s.data[4 * k] = sum(y_whole[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    s.quarter[4 * k + 6] = sum(halves[k]), s.data[4 * k + 6] = sum(y_halves[k]);
    s.quarter[4 * k + 5] = sum(five[k]), s.data[4 * k + 5] = sum(y_five[k]);
  }
  for (std::size_t k = 0; k < 4; ++k)
    s.quarter[4 * k + 3] = sum(three[k]), s.data[4 * k + 3] = sum(y_three[k]);
  return s;
}

Sums sums_of(const SharedSums& s, double law) {
  Sums out;
  const auto q = static_cast<std::size_t>(4 * law);
  for (std::size_t j = 0; j < terms; ++j)
    for (std::size_t k = 0; k <= j; ++k) out.square[j][k] = s.half[q + 2 * (j + k)];
  for (std::size_t k = 0; k < terms; ++k)
    out.plain[k] = s.quarter[q + 4 * k], out.data[k] = s.data[q + 4 * k];
  return out;
}

/// Rows near the edge as the amplifier shows them, in place of the bare powers.
void smooth(std::array<Sums, laws.size()>& sums, const Rows& r, double t0, double span) {
  const double from = r.side > 0 ? smoothed_from_touch : smoothed_from_release, unit = r.delay / span;
  QuarterPowers scale, shown, bare;
  const double root = std::sqrt(std::sqrt(unit));
  scale[0] = 1;
  for (std::size_t p = 1; p < scale.size(); ++p) scale[p] = scale[p - 1] * root;
  auto i = static_cast<std::size_t>(
      std::partition_point(r.t.begin(), r.t.end(), [&](double t) { return t < t0 + from * r.delay; }) -
      r.t.begin());
  for (; i < r.t.size() && r.t[i] < t0 + smoothed_to * r.delay; ++i) {
    smoothed_powers((r.t[i] - t0) / r.delay, r.side, shown);
    const double tau = std::max((r.t[i] - t0) / span, 0.0), fourth = std::sqrt(std::sqrt(tau));
    bare[0] = tau > 0;
    for (std::size_t p = 1; p < bare.size(); ++p) bare[p] = bare[p - 1] * fourth;
    for (std::size_t p = 0; p < shown.size(); ++p) shown[p] *= scale[p];
    for (std::size_t l = 0; l < laws.size(); ++l) {
      const auto q = static_cast<std::size_t>(4 * laws[l]);
      Sums& s = sums[l];
      for (std::size_t j = 0; j < terms; ++j) {
        const double g = shown[q + 4 * j], b = bare[q + 4 * j];
        s.plain[j] += g - b;
        s.data[j] += r.y[i] * (g - b);
        for (std::size_t k = 0; k <= j; ++k) s.square[j][k] += g * shown[q + 4 * k] - b * bare[q + 4 * k];
      }
    }
  }
}

/// Of all laws with the edge at `t0`: log of the summed evidence, and what the best one leaves.
Evidence evidence_at(const Rows& r, const Totals& all, double t0, double span, bool breaks, bool with_chi2) {
  const SharedSums shared = shared_sums(r, t0, span);
  std::array<Sums, laws.size()> sums;
  for (std::size_t l = 0; l < laws.size(); ++l) sums[l] = sums_of(shared, laws[l]);
  if (r.delay > 0) smooth(sums, r, t0, span);
  Evidence best;
  std::array<double, laws.size()> logs{};
  for (std::size_t l = 0; l < laws.size(); ++l) {
    const Evidence e = evidence_of(sums[l], all, largest_term * r.top / r.noise, zero_error,
                                   breaks && laws[l] == 0, with_chi2);
    logs[l] = e.log + log_before[l];
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
  const Totals all = totals_of(r);
  auto nodes = std::clamp<std::size_t>(static_cast<std::size_t>((to - from) / r.step), 24, 160);
  double at_best = from;
  for (int pass = 0; pass < 3; ++pass, nodes = 32) {
    const double step = (to - from) / static_cast<double>(nodes);
    std::vector<Evidence> at(nodes + 1);
    std::size_t best = 0;
    for (std::size_t k = 0; k <= nodes; ++k) {
      at[k] = evidence_at(r, all, from + static_cast<double>(k) * step, span, breaks, false);
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
    p = {from + mean, std::sqrt(std::max(squares / weight - mean * mean, step * step / 12)), 0};
    at_best = from + static_cast<double>(best) * step;
    to = from + step * static_cast<double>(std::min(last + 1, nodes));
    from += step * (first > 0 ? static_cast<double>(first - 1) : 0.0);
    if (static_cast<double>(last - first) > 0.8 * static_cast<double>(nodes) && pass > 0) break;
  }
  p.chi2 = evidence_at(r, all, at_best, span, breaks, true).chi2;
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
  out.time = {q.near + q.side * p.mean,
              std::hypot(p.sigma, std::hypot(s.dt / 12, amplifier_share * q.delay))};
  return out;
}

}  // namespace

EdgeAnswer locate_edge_beyond(const Signal& s, const EdgeQuestion& q, double foot) {
  EdgeAnswer out;
  const auto beyond = [&](const EdgeQuestion& asked) {
    Rows r = rows_of(s, asked, q.closed);
    std::size_t kept = 0;
    r.closed = 0;
    for (std::size_t i = 0; i < r.t.size(); ++i) {
      if (r.t[i] > 0 && r.t[i] < foot) continue;
      r.t[kept] = r.t[i], r.y[kept] = r.y[i];
      r.closed += r.t[kept++] > 0;
    }
    r.t.resize(kept), r.y.resize(kept);
    out.known = r.closed >= least_rows && kept >= least_rows + 3;
    if (!out.known) return;
    const Posterior p = posterior_of(r, -0.3 * q.open, foot, q.closed, false);
    const double dof = std::max(1.0, static_cast<double>(kept) - unknowns - 1);
    out.reduced_chi2 = p.chi2 / dof;
    out.followed = out.reduced_chi2 < 1 + 3 * std::sqrt(2 / dof);
    out.span = q.closed;
    out.time = {q.near + q.side * p.mean, std::hypot(p.sigma, s.dt / 12)};
  };
  beyond(q);
  if (!out.known || out.followed) return out;
  EdgeQuestion noisier = q;
  noisier.noise *= std::sqrt(out.reduced_chi2);
  beyond(noisier);
  return out;
}

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

}  // namespace powbench::dsp
