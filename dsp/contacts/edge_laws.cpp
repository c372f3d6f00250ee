#include "dsp/contacts/edge_laws.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dsp/contacts/amplifier.h"
#include "dsp/signal/wide.h"

namespace powbench::dsp {

namespace {

constexpr std::size_t law_count = edge_laws;

/// Four times the exponents 0, 0.75, 1, 1.25, 1.5, 1.75, 2: the place of a law's first power in a table of quarter
/// powers. The lane behind the last law repeats it and weighs nothing.
constexpr std::array<std::size_t, wide_lanes> first_power{0, 3, 4, 5, 6, 7, 8, 8};
/// Most pads are springs or round.
constexpr Wide before{0.3, 0.3, 1, 1, 1, 0.3, 0.1, 0};
constexpr double largest_term = 3;  // standard deviation of a term over the largest force in sight
/// The same of a3 in a jump: pads that stick to the end break, with little after it. None behind an amplifier's
/// low-pass, where nothing jumps.
constexpr double last_at_touch = 1, last_at_release = 0.1;
constexpr double zero_error = 2;                 // of the open level, over the noise
constexpr double pulls = 3.3546262790251185e-4;  // e^-8: weight of a law that begins by pulling

/// Sums of all laws over the rows, a lane each: products of their terms j >= k, the terms, and y times the terms.
template <std::size_t terms>
struct Sums {
  Wide square[terms][terms], plain[terms], data[terms];
};

/// Sums over the rows behind an edge that the laws share: powers of tau in steps of a half up to 8, and of a quarter
/// up to 4, the latter also times the data. Four rows at a time.
struct SharedSums {
  static constexpr std::size_t lanes = 4;
  using Lane = std::array<double, lanes>;
  std::array<double, 17> half{};
  std::array<double, 17> quarter{}, data{};
};

POWBENCH_WIDE SharedSums shared_sums(const EdgeRows& r, double t0, double span) {
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

/// Half of the lanes of a Wide: what one register of AVX2 holds.
using Half = double __attribute__((vector_size(wide_lanes * sizeof(double) / 2), may_alias));

POWBENCH_WITHIN_WIDE Half& half(Wide& w, std::size_t h) {
  return reinterpret_cast<Half*>(&w)[h];
}

/// p[first_power], a lane each, in two halves.
struct Lanes {
  Half low, high;
};
POWBENCH_WITHIN_WIDE Lanes lanes_of(const double* p) {
  static_assert(first_power == std::array<std::size_t, wide_lanes>{0, 3, 4, 5, 6, 7, 8, 8});
  return {Half{p[0], p[3], p[4], p[5]}, Half{p[6], p[7], p[8], p[8]}};
}

template <std::size_t terms>
POWBENCH_WITHIN_WIDE void sums_of(const SharedSums& s, Sums<terms>& out) {
  const auto put = [](Wide& to, const double* from) {
    const Lanes v = lanes_of(from);
    half(to, 0) = v.low, half(to, 1) = v.high;
  };
  for (std::size_t j = 0; j < edge_terms; ++j) {
    for (std::size_t k = 0; k <= j; ++k) put(out.square[j][k], s.half.data() + 2 * (j + k));
    put(out.plain[j], s.quarter.data() + 4 * j);
    put(out.data[j], s.data.data() + 4 * j);
  }
  // a jump alone may have one more: over a long span it bends as a power does that begins steeply
  for (std::size_t j = edge_terms; j < terms; ++j) {
    for (std::size_t k = 0; k <= j; ++k) out.square[j][k] = Wide{s.half[2 * (j + k)]};
    out.plain[j] = Wide{s.quarter[4 * j]}, out.data[j] = Wide{s.data[4 * j]};
  }
}

/// Rows near the edge as the amplifier shows them, in place of the bare powers.
POWBENCH_WITHIN_WIDE void smooth(Sums<edge_terms>& s, const EdgeRows& r, double t0, double span) {
  constexpr std::size_t terms = edge_terms;
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
    Half g[terms][2], b[terms][2];
    for (std::size_t j = 0; j < terms; ++j) {
      const Lanes v = lanes_of(shown.data() + 4 * j), w = lanes_of(bare.data() + 4 * j);
      g[j][0] = v.low, g[j][1] = v.high, b[j][0] = w.low, b[j][1] = w.high;
    }
    for (std::size_t j = 0; j < terms; ++j)
      for (std::size_t h = 0; h < 2; ++h) {
        const Half more = g[j][h] - b[j][h];
        half(s.plain[j], h) += more;
        half(s.data[j], h) += r.y[i] * more;
        for (std::size_t k = 0; k <= j; ++k) half(s.square[j][k], h) += g[j][h] * g[k][h] - b[j][h] * b[k][h];
      }
  }
}

/// `last`: of a3, where there are four terms.
template <std::size_t terms>
POWBENCH_WITHIN_WIDE EdgeEvidence evidence_of(const EdgeRows& r, const EdgeTotals& all, double t0,
                                              double span, bool breaks, double last, bool with_chi2) {
  const SharedSums shared = shared_sums(r, t0, span);
  Sums<terms> s;
  sums_of(shared, s);
  if constexpr (terms == edge_terms)
    if (r.delay > 0) smooth(s, r, t0, span);
  // Normal equations with unit priors, the zero first and a0 last, whose sign is asked for: L D L^T without roots.
  constexpr std::size_t n = terms + 1;
  const double top = r.top / r.noise;
  double scale[n];
  for (std::size_t j = 1; j < n; ++j) scale[j] = (terms - j < edge_terms ? largest_term : last) * top;
  Wide m[n][n], b[n], d[n], z[n];
  const Wide one = {1, 1, 1, 1, 1, 1, 1, 1};
  m[0][0] = (zero_error * zero_error * all.n + 1) * one;
  b[0] = zero_error * all.y * one;
  for (std::size_t j = 1; j < n; ++j) {
    const std::size_t p = terms - j;
    m[j][0] = scale[j] * zero_error * s.plain[p];
    b[j] = scale[j] * s.data[p];
    for (std::size_t k = 1; k <= j; ++k) {
      m[j][k] = scale[j] * scale[k] * s.square[terms - k][p];
      if (j == k) m[j][k] += one;
    }
  }
  Wide lower[n][n], gain = {}, determinant = one;
  for (std::size_t j = 0; j < n; ++j) {
    Wide u[n];
    d[j] = m[j][j], z[j] = b[j];
    for (std::size_t k = 0; k < j; ++k) {
      u[k] = m[j][k];
      for (std::size_t i = 0; i < k; ++i) u[k] -= u[i] * lower[k][i];
      lower[j][k] = u[k] / d[k];
      d[j] -= u[k] * lower[j][k];
      z[j] -= lower[j][k] * z[k];
    }
    determinant *= d[j];
    gain += z[j] * z[j] / d[j];
  }
  double most = gain[0];
  for (std::size_t l = 1; l < law_count; ++l) most = std::max(most, gain[l]);
  std::array<double, edge_laws> share{};
  double sum = 0, best = -1;
  std::size_t at = 0;
  for (std::size_t l = 0; l < law_count; ++l) {
    const bool pulling = z[n - 1][l] < 0 && !(breaks && first_power[l] == 0);
    const double v =
        before[l] * (pulling ? pulls : 1.0) * std::exp(0.5 * (gain[l] - most)) / std::sqrt(determinant[l]);
    sum += v, share[l] = v;
    if (v > best) best = v, at = l;
  }
  for (std::size_t l = 0; l < law_count; ++l) share[l] /= sum;
  EdgeEvidence e{0.5 * most + std::log(sum), share, 0};
  if (!with_chi2) return e;
  double x[n];
  for (std::size_t j = n; j-- > 0;) {
    x[j] = z[j][at] / d[j][at];
    for (std::size_t i = j + 1; i < n; ++i) x[j] -= lower[i][j][at] * x[i];
  }
  e.chi2 = all.yy;  // |y - X x|^2 without the priors
  for (std::size_t j = 0; j < n; ++j) {
    e.chi2 -= 2 * x[j] * b[j][at];
    for (std::size_t k = 0; k < n; ++k)
      e.chi2 += x[j] * x[k] * (m[std::max(j, k)][std::min(j, k)][at] - (j == k ? 1.0 : 0.0));
  }
  return e;
}

}  // namespace

double law_prior(std::size_t law) {
  return before[law];
}

EdgeTotals totals_of(const EdgeRows& r) {
  EdgeTotals t{static_cast<double>(r.t.size()), 0, 0};
  for (const double v : r.y) t.y += v, t.yy += v * v;
  return t;
}

POWBENCH_WIDE EdgeEvidence evidence_at(const EdgeRows& r, const EdgeTotals& all, double t0, double span,
                                       bool breaks, bool with_chi2) {
  if (r.delay > 0) return evidence_of<edge_terms>(r, all, t0, span, breaks, 0, with_chi2);
  return evidence_of<edge_terms + 1>(r, all, t0, span, breaks, breaks ? last_at_release : last_at_touch,
                                     with_chi2);
}

}  // namespace powbench::dsp
