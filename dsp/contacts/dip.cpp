#include "dsp/contacts/dip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dsp/signal/least_squares.h"

namespace powbench::dsp {

namespace {

constexpr std::array<double, 3> laws{1, 1.25, 1.5};
constexpr std::size_t middle_law = 1;
constexpr double hopeless = 2;   // reduced chi-square of the middle law that no other mends
constexpr double shrink = 0.75;  // of the span, from one look to the next
constexpr std::size_t most_rows = 48, least_rows = 12;
constexpr double negligible = 24;                      // of chi-square above the best
constexpr double excluded = 24;                        // the same, of m = 0
constexpr double beyond_doubt = 100;                   // the same
constexpr double enough = 0.003;                       // gain of an iteration in chi-square
constexpr int trial = 5, longest = 20, profiled = 10;  // iterations: of a start, of a fit, with m held
constexpr double friction = 0.15;                      // standard deviation of e
constexpr double zero_error = 1.5;                     // of z, over the noise of a mean over 20 us
constexpr double slower = 1.5;                         // root of the rows that vibration moves as one
constexpr double clear = 6;                            // noises of a row that both ends must stand above zero

struct Rows {
  std::vector<double> x, y;             // -1 .. 1; in units of `top`
  double noise = 0, zero = 0, top = 0;  // noise of a row; error of the zero
  double half = 0;                      // s, of the span
};

double power(double w, double q) {
  if (q == 1.5) return w * std::sqrt(w);
  if (q == 1) return w;
  if (q == 2) return w * w;
  if (q == 0.5) return std::sqrt(w);
  if (q == 0) return 1;
  const double root = std::sqrt(std::sqrt(w));
  return q == 1.25 ? w * root : q == 0.25 ? root : std::pow(w, q);
}

std::optional<Rows> rows_of(const Signal& s, double from, double to, double noise, double wander) {
  const std::size_t i1 = s.index_at(from), i2 = std::min(s.index_at(to) + 1, s.size());
  if (i2 < i1 + least_rows) return std::nullopt;
  const std::size_t per_row = std::max<std::size_t>(1, (i2 - i1) / most_rows);
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  Rows r;
  r.half = half;
  for (std::size_t i = i1; i + per_row <= i2; i += per_row) {
    double sum = 0;
    std::uint8_t mask = 0;
    for (std::size_t k = i; k < i + per_row; ++k) sum += s.value[k], mask |= s.masked[k];
    if (mask != mask_none) return std::nullopt;
    r.x.push_back((s.time(i) + 0.5 * static_cast<double>(per_row - 1) * s.dt - middle) / half);
    r.y.push_back(sum / static_cast<double>(per_row));
  }
  r.top = std::max(r.y.front(), r.y.back());
  r.noise = noise / std::sqrt(static_cast<double>(per_row));
  if (!(std::min(r.y.front(), r.y.back()) > clear * r.noise)) return std::nullopt;
  for (double& v : r.y) v /= r.top;
  r.noise /= r.top;
  r.zero = std::hypot(zero_error * noise * std::sqrt(std::min(1.0, s.dt / 20e-6)), wander) / r.top;
  return r;
}

constexpr std::size_t unknowns = 7, priors = 2;
using Parameters = std::array<double, unknowns>;  // m, x0, b, c, d, e, z

/// `fixed` holds m and leaves it out.
LeastSquares fit(const Rows& r, double q, const Parameters& start, bool fixed, int iterations) {
  const std::size_t n = r.x.size(), skip = fixed ? 1 : 0, rows = n + priors;
  const std::array<FreeParameter, unknowns> all{{{start[0], 1e-4, -3, 1},
                                                 {start[1], 1e-4, -0.9, 0.9},
                                                 {start[2], 1e-4, 0.02, 30},
                                                 {start[3], 1e-4, -20, 20},
                                                 {start[4], 1e-4, -20, 20},
                                                 {start[5], 1e-4, -0.5, 0.5},
                                                 {start[6], 1e-5, -0.2, 0.2}}};
  const double level = r.zero;
  const auto walk = [&](std::span<const double> given, auto&& at) {
    Parameters p = start;
    std::copy(given.begin(), given.end(), p.begin() + static_cast<std::ptrdiff_t>(skip));
    for (std::size_t i = 0; i < n; ++i) {
      const double x = r.x[i] - p[1], side = x < 0 ? -1 : 1, b = p[2] * (1 + side * p[5]);
      at(i, p, x, side, p[0] + x * x * (b + x * (p[3] + x * p[4])),
         -x * (2 * b + x * (3 * p[3] + 4 * x * p[4])));
    }
  };
  const auto residuals = [&](std::span<const double> p, std::span<double> out) {
    walk(p, [&](std::size_t i, const Parameters&, double, double, double w, double) {
      out[i] = ((w > 0 ? power(w, q) : 0.0) + p[6 - skip] - r.y[i]) / r.noise;
    });
    out[n] = p[5 - skip] / friction;
    out[n + 1] = p[6 - skip] / level;
  };
  const auto derivatives = [&](std::span<const double> given, std::span<double> j) {
    std::fill(j.begin(), j.end(), 0.0);
    walk(given, [&](std::size_t i, const Parameters& p, double x, double side, double w, double by_x0) {
      j[(6 - skip) * rows + i] = 1 / r.noise;
      if (!(w > 0)) return;
      const double slope = q * power(w, q - 1) / r.noise, xx = x * x;
      const std::array<double, 6> by{1, by_x0, xx * (1 + side * p[5]), xx * x, xx * xx, side * xx * p[2]};
      for (std::size_t k = skip; k < by.size(); ++k) j[(k - skip) * rows + i] = slope * by[k];
    });
    j[(5 - skip) * rows + n] = 1 / friction;
    j[(6 - skip) * rows + n + 1] = 1 / level;
  };
  return levenberg_marquardt(residuals, rows, std::span(all).subspan(skip), iterations, derivatives, enough);
}

/// chi-square along m.
struct Profile {
  double best = 1e300, step = 1;
  std::vector<double> m, chi2;
  double at_zero = 0;  ///< chi-square with m = 0
};

/// A span that the model followed, as the start of the next narrower one.
Parameters narrowed(const Parameters& p, double q, const Rows& from, const Rows& to) {
  const double share = to.half / from.half, lower = from.top / to.top, w = std::pow(lower, 1 / q);
  const double square = share * share;
  return {p[0] * w, p[1] / share, p[2] * square * w, p[3] * square * share * w, p[4] * square * square * w,
          p[5],     p[6] * lower};
}

/// The optimum. Without a `start` of its own (`warm`) an open and a closed one are tried, and the better followed.
Profile optimum_of(const Rows& r, double q, Parameters& at, bool warm) {
  const auto parameters = [](const LeastSquares& l) {
    Parameters p{};
    std::copy(l.x.begin(), l.x.end(), p.begin());
    return p;
  };
  LeastSquares free;
  if (warm) {
    free = fit(r, q, at, false, longest);
  } else {
    const auto width = [&](double y) { return std::pow(std::max(y, r.noise), 1 / q); };
    const double left = width(r.y.front()), right = width(r.y.back()), b = 0.5 * (left + right);
    const double x0 = std::clamp((left - right) / (4 * b), -0.5, 0.5);
    free = fit(r, q, {0.01, x0, b, 0, 0, 0, 0}, false, trial);
    LeastSquares open = fit(r, q, {-0.1, x0, 1.2 * b, 0, 0, 0, 0}, false, trial);
    if (open.chi2 < free.chi2) std::swap(free, open);
    if (!free.converged) free = fit(r, q, parameters(free), false, longest - trial);
    // one that stands within sight of the better one may yet pass it
    if (!open.converged && open.chi2 < free.chi2 + beyond_doubt) {
      open = fit(r, q, parameters(open), false, longest - trial);
      if (open.chi2 < free.chi2) free = std::move(open);
    }
  }
  at = parameters(free);
  Profile out;
  out.best = free.chi2;
  out.step = std::clamp(0.6 * free.u(0), 2e-3, 0.1);
  out.m = {at[0]}, out.chi2 = {free.chi2};
  return out;
}

/// From the optimum outwards in both directions until it is negligible.
void walk_along(const Rows& r, double q, const Parameters& optimum, Profile& p) {
  for (const double side : {-1.0, 1.0}) {
    Parameters at = optimum;
    for (int k = 0; k < 40; ++k) {
      at[0] += side * p.step;
      const LeastSquares l = fit(r, q, at, true, profiled);
      std::copy(l.x.begin(), l.x.end(), at.begin() + 1);
      p.m.push_back(at[0]), p.chi2.push_back(l.chi2), p.best = std::min(p.best, l.chi2);
      if (l.chi2 > p.best + negligible || at[0] < -2.5 || at[0] > 0.8) break;
    }
  }
}

/// `at`: optima of the laws, found here; with `warm` the start too.
Dip dip_in(const Rows& r, std::array<Parameters, laws.size()>& at, bool warm) {
  Dip out;
  std::array<Profile, laws.size()> all;
  double best = 1e300;
  const double dof = std::max(1.0, static_cast<double>(r.x.size() + priors - unknowns));
  for (const std::size_t l : {middle_law, middle_law - 1, middle_law + 1}) {
    all[l] = optimum_of(r, laws[l], at[l], warm);
    best = std::min(best, all[l].best);
    if (l == middle_law && best > hopeless * dof) break;  // its neighbours bend like it
  }
  out.reduced_chi2 = best / dof;
  out.known = out.reduced_chi2 < 1 + 1.2 * std::sqrt(2 / dof);
  out.noise = r.noise;
  if (!out.known) return out;
  double zero = 1e300;
  for (std::size_t l = 0; l < laws.size(); ++l) {
    Parameters start = at[l];
    start[0] = 0;
    all[l].at_zero = fit(r, laws[l], start, true, profiled).chi2;
    zero = std::min(zero, all[l].at_zero);
  }
  out.sure = zero > best + beyond_doubt;
  for (std::size_t l = 0; l < laws.size(); ++l)
    if (all[l].at_zero < all[l].best + excluded && all[l].best < best + negligible)
      walk_along(r, laws[l], at[l], all[l]);
  double open = 0, sum = 0;
  for (const Profile& p : all)
    for (std::size_t i = 0; i < p.m.size(); ++i) {
      const double weight = p.step * std::exp(-0.5 * (p.chi2[i] - best));
      sum += weight;
      open += weight * std::clamp(0.5 - p.m[i] / p.step, 0.0, 1.0);  // the node's share below zero
    }
  out.opened = open / sum;
  return out;
}

}  // namespace

Dip look_at_dip(const Signal& force, double release, double touch, double closed, double noise,
                double wander) {
  const double gap = std::max(touch - release, 0.0);
  Dip last, doubtful;
  int followed = 0;
  double beside = std::min(std::max(2 * gap, 150e-6), closed);
  const auto rows_beside = [&] { return rows_of(force, release - beside, touch + beside, noise, wander); };
  std::array<Parameters, laws.size()> at{};
  std::optional<Rows> before, nearest;
  double least_left = 1e300;
  while (beside < closed && !rows_beside()) beside = std::min(1.4 * beside, closed);
  for (; beside > 5 * force.dt; beside *= shrink) {
    const auto rows = rows_beside();
    if (!rows) break;
    if (before)
      for (std::size_t l = 0; l < laws.size(); ++l) at[l] = narrowed(at[l], laws[l], *before, *rows);
    last = dip_in(*rows, at, before.has_value());
    if (!last.known && last.reduced_chi2 < least_left && beside > gap)
      nearest = rows, least_left = last.reduced_chi2;
    if (!last.known) continue;
    before = rows;
    // A span that the model follows only nearly is surer than it may be: of three the most doubtful one counts.
    if (!doubtful.known || std::abs(last.opened - 0.5) < std::abs(doubtful.opened - 0.5)) doubtful = last;
    if (last.sure || ++followed == 3) break;
  }
  if (doubtful.known || !nearest) return doubtful.known ? doubtful : last;
  // what no law follows, such as vibration, is more noise: as much as the nearest law leaves beyond it, and slower
  const double white = nearest->noise;
  nearest->noise *= std::sqrt(1 + slower * slower * std::max(least_left - 1, 0.0));
  nearest->zero = std::hypot(nearest->zero, nearest->noise);
  std::array<Parameters, laws.size()> afresh{};
  last = dip_in(*nearest, afresh, false);
  last.noise = white;
  return last;
}

}  // namespace powbench::dsp
