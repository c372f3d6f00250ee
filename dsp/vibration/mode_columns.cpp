#include "dsp/vibration/mode_columns.h"

#include <algorithm>
#include <array>
#include <vector>

#include "dsp/signal/wide.h"

namespace powbench::dsp {

namespace {

constexpr std::size_t lanes = wide_lanes, afresh = 128;  // rows

/// `count` doubles, at most eight; the other lanes are 0.
POWBENCH_WITHIN_WIDE void get(Wide& v, const double* from, std::size_t count) {
  if (count >= lanes) {
    v = *reinterpret_cast<const WideView*>(from);
    return;
  }
  v = Wide{};
  for (std::size_t l = 0; l < count; ++l) v[l] = from[l];
}

POWBENCH_WITHIN_WIDE void put(double* to, const Wide& v, std::size_t count) {
  if (count >= lanes) {
    *reinterpret_cast<WideView*>(to) = v;
    return;
  }
  for (std::size_t l = 0; l < count; ++l) to[l] = v[l];
}

/// Rows of up to `afresh` from one start: the first eight by multiplication, then eight at a time.
POWBENCH_WIDE void turn_on(std::complex<double> first, std::complex<double> turn, std::size_t n, double* c,
                           double* d) {
  Wide re{}, im{};
  double x = first.real(), y = first.imag();
  double p = 1, q = 0;  // turn^l
  for (std::size_t l = 0; l < lanes; ++l) {
    re[l] = x * p - y * q, im[l] = x * q + y * p;
    const double next = p * turn.real() - q * turn.imag();
    q = p * turn.imag() + q * turn.real(), p = next;
  }
  for (std::size_t i = 0; i < n; i += lanes) {
    put(c + i, re, n - i), put(d + i, im, n - i);
    const Wide next = re * p - im * q;
    im = re * q + im * p, re = next;
  }
}

}  // namespace

void mode_columns(std::complex<double> s, std::complex<double> gain, double tau, double dt, std::size_t n,
                  double* c, double* d) {
  const std::complex<double> turn = std::exp(s * dt);
  for (std::size_t i = 0; i < n; i += afresh)
    turn_on(gain * std::exp(s * (tau + static_cast<double>(i) * dt)), turn, std::min(afresh, n - i), c + i,
            d + i);
}

POWBENCH_WIDE void mode_block(const BlockRows& r, double reference, double x, double y, double* c, double* d,
                              double* by_frequency, double* by_decay) {
  for (std::size_t i = 0; i < r.n; i += lanes) {
    const std::size_t count = r.n - i;
    Wide re, im, t, w, model;
    get(re, c + i, count), get(im, d + i, count), get(t, r.t + i, count), get(w, r.weight + i, count);
    get(model, r.model + i, count);
    const Wide value = x * re + y * im, tau = (t - reference) * w;
    put(r.model + i, model + value, count);
    put(by_frequency + i, tau * (y * re - x * im), count);
    put(by_decay + i, -tau * value, count);
    put(c + i, re * w, count), put(d + i, im * w, count);
  }
}

namespace {

POWBENCH_WIDE void rise_rows(const BlockRows& r, const double* falls, double touch, double rise, double span,
                             const double* linear, double* columns, std::size_t stride) {
  const double per = 2 / span;
  for (std::size_t i = 0; i < r.n; i += lanes) {
    const std::size_t count = r.n - i;
    Wide fall, t, w, model;
    get(fall, falls + i, count), get(t, r.t + i, count), get(w, r.weight + i, count),
        get(model, r.model + i, count);
    const Wide tau = t - touch, up = 1 - fall, u = per * tau - 1, weighted = up * w;
    // Chebyshev polynomials and their sum's slope
    Wide before = Wide{} + 1.0, now = u, slope_before = {}, slope_now = Wide{} + 1.0;
    Wide value = Wide{} + linear[0], slope = {};
    if (columns) put(columns + 2 * stride + i, weighted, count);
    for (std::size_t k = 1; k < rise_terms; ++k) {
      value += linear[k] * now;
      slope += linear[k] * slope_now;
      if (columns) put(columns + (2 + k) * stride + i, weighted * now, count);
      const Wide next = 2 * u * now - before, slope_next = 2 * now + 2 * u * slope_now - slope_before;
      before = now, now = next, slope_before = slope_now, slope_now = slope_next;
    }
    put(r.model + i, model + up * value, count);
    if (!columns) continue;
    const Wide steep = fall * w * value / rise;
    put(columns + i, -(steep + weighted * slope * per), count);
    put(columns + stride + i, -steep * tau, count);
  }
}

}  // namespace

void rise_block(const BlockRows& r, double touch, double rise, double dt, double span, const double* linear,
                double* columns, std::size_t stride) {
  const std::size_t open = static_cast<std::size_t>(std::upper_bound(r.t, r.t + r.n, touch) - r.t);
  if (columns)
    for (std::size_t k = 0; k < 2 + rise_terms; ++k) std::fill_n(columns + k * stride, open, 0.0);
  const BlockRows closed{r.n - open, r.t + open, r.weight + open, r.model + open};
  if (closed.n == 0) return;
  std::vector<double> fall(2 * closed.n);
  mode_columns(-1 / rise, 1.0, closed.t[0] - touch, dt, closed.n, fall.data(), fall.data() + closed.n);
  rise_rows(closed, fall.data(), touch, rise, span, linear, columns ? columns + open : nullptr, stride);
}

}  // namespace powbench::dsp
