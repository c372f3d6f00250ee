#include "dsp/contacts/edge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dsp/contacts/amplifier.h"
#include "dsp/contacts/edge_laws.h"

namespace powbench::dsp {

namespace {

constexpr double negligible = 16;  // e^-16 of the best counts no more
constexpr std::size_t fine_nodes =
    14;                         // over what counts, eleven deviations of a normal law: the sums are exact
constexpr double shrink = 0.6;  // of the span, from one look to the next
constexpr std::size_t most_rows = 96, least_rows = 6;

/// Means of as many samples as leave `most_rows` over `span`.
EdgeRows edge_rows(const Signal& s, const EdgeQuestion& q, double span) {
  EdgeRows r;
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

struct Posterior {
  double mean = 0, sigma = 0, chi2 = 0;
  std::array<EdgeLaw, edge_laws> law;  ///< by law, relative to `mean`
};

/// Mean and deviation of t0 over [from, to], the grid drawn together around what counts.
Posterior posterior_of(const EdgeRows& r, double from, double to, double span, bool breaks) {
  Posterior p;
  const EdgeTotals all = totals_of(r);
  auto nodes = std::clamp<std::size_t>(static_cast<std::size_t>((to - from) / r.step), 24, 160);
  double at_best = from;
  for (int pass = 0; pass < 3; ++pass, nodes = 32) {
    const double step = (to - from) / static_cast<double>(nodes);
    std::vector<EdgeEvidence> at(nodes + 1);
    std::size_t best = 0;
    for (std::size_t k = 0; k <= nodes; ++k) {
      at[k] = evidence_at(r, all, from + static_cast<double>(k) * step, span, breaks, false);
      if (at[k].log > at[best].log) best = k;
    }
    double weight = 0, sum = 0, squares = 0;
    std::array<std::array<double, 3>, edge_laws> moment{};  // 1, t, t^2, by law
    std::size_t first = nodes, last = 0;
    for (std::size_t k = 0; k <= nodes; ++k) {
      const double below = at[best].log - at[k].log;
      if (below > negligible) continue;
      first = std::min(first, k), last = std::max(last, k);
      const double w = std::exp(-below), t = static_cast<double>(k) * step;
      weight += w, sum += w * t, squares += w * t * t;
      for (std::size_t l = 0; l < edge_laws; ++l) {
        const double share = w * at[k].share[l];
        moment[l][0] += share, moment[l][1] += share * t, moment[l][2] += share * t * t;
      }
    }
    const double mean = sum / weight;
    p = {from + mean, std::sqrt(std::max(squares / weight - mean * mean, step * step / 12)), 0, {}};
    for (std::size_t l = 0; l < edge_laws; ++l) {
      const auto& [of_law, first_moment, second] = moment[l];
      if (!(of_law > 0)) continue;
      const double m = first_moment / of_law;
      p.law[l] = {of_law / weight, m - mean, std::sqrt(std::max(second / of_law - m * m, step * step / 12))};
    }
    at_best = from + static_cast<double>(best) * step;
    to = from + step * static_cast<double>(std::min(last + 1, nodes));
    from += step * (first > 0 ? static_cast<double>(first - 1) : 0.0);
    if (last - first > fine_nodes && pass > 0) break;
  }
  p.chi2 = evidence_at(r, all, at_best, span, breaks, true).chi2;
  return p;
}

}  // namespace

namespace {

/// The edge with the force up to `span` from it. `follows`: the laws are not known to miss it.
EdgeAnswer within(const Signal& s, const EdgeQuestion& q, double span, bool follows = true) {
  EdgeAnswer out;
  const EdgeRows r = edge_rows(s, q, span);
  if (r.closed < least_rows || r.t.size() < least_rows + 3) return out;
  out.span = *std::max_element(r.t.begin(), r.t.end());
  const Posterior p = posterior_of(r, -0.6 * q.open, 0.6 * out.span, out.span, q.side < 0);
  const double dof = std::max(1.0, static_cast<double>(r.t.size()) - edge_unknowns - 1);
  out.known = true;
  out.reduced_chi2 = p.chi2 / dof;
  out.followed = out.reduced_chi2 < 1 + 3 * std::sqrt(2 / dof);
  // behind a slower amplifier the force between the samples is in laws that follow
  const double between = q.delay > s.dt && follows ? 0 : s.dt / 12;
  out.time = {q.near + q.side * p.mean, std::hypot(p.sigma, std::hypot(between, amplifier_share * q.delay))};
  for (std::size_t l = 0; l < edge_laws; ++l)
    out.law[l] = {p.law[l].weight, q.side * p.law[l].mean, p.law[l].sigma};
  return out;
}

}  // namespace

EdgeAnswer locate_edge_beyond(const Signal& s, const EdgeQuestion& q, double foot) {
  EdgeAnswer out;
  const auto beyond = [&](const EdgeQuestion& asked) {
    EdgeRows r = edge_rows(s, asked, q.closed);
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
    const double dof = std::max(1.0, static_cast<double>(kept) - edge_unknowns - 1);
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
  wide = within(s, noisier, span, false);
  wide.followed = false;
  wide.reduced_chi2 = misfit;
  return wide;
}

}  // namespace powbench::dsp
