#include "dsp/signal/mains.h"

#include <algorithm>
#include <cmath>

#include "core/phase.h"
#include "dsp/signal/least_squares.h"

namespace powbench::dsp {

namespace {

constexpr double block_seconds = 50e-6;

struct Blocks {
  std::vector<double> time, value;
  double width = 0;  ///< samples per block
  double dt = 0;     ///< s, of the samples
};

Blocks average_blocks(const Signal& s, double t1, double t2) {
  Blocks b;
  const auto per = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(block_seconds / s.dt)));
  b.width = static_cast<double>(per);
  b.dt = s.dt;
  const std::size_t last = s.index_at(t2);
  for (std::size_t i = s.index_at(t1); i + per <= last; i += per) {
    double sum = 0;
    bool good = true;
    for (std::size_t k = i; k < i + per; ++k) {
      good = good && !s.masked[k];
      sum += s.value[k];
    }
    if (!good) continue;
    b.time.push_back(s.time(i) + 0.5 * (b.width - 1) * s.dt);
    b.value.push_back(sum / b.width);
  }
  return b;
}

/// Gain of averaging `width` samples, at w rad/s: a sine's amplitude shrinks by this.
double block_gain(const Blocks& b, double w) {
  const double half = 0.5 * w * b.dt;
  return b.width == 1 ? 1.0 : std::sin(b.width * half) / (b.width * std::sin(half));
}

/// One linear fit at w; with `derivative`, the last column is d/dw of the previous solution.
LeastSquares solve(const Blocks& b, HarmonicFit& fit, bool derivative) {
  const double w = 2 * pi * fit.hertz;
  const std::size_t n = b.time.size(), k = fit.order.size();
  std::vector<std::vector<double>> columns(1 + 2 * k + (derivative ? 1 : 0), std::vector<double>(n, 0.0));
  columns[0].assign(n, 1.0);
  for (std::size_t j = 0; j < k; ++j) {
    const double wj = w * fit.order[j], g = block_gain(b, wj);
    for (std::size_t i = 0; i < n; ++i) {
      const double tau = b.time[i] - fit.centre, c = g * std::cos(wj * tau), s = g * std::sin(wj * tau);
      columns[1 + 2 * j][i] = c;
      columns[2 + 2 * j][i] = s;
      if (derivative) columns.back()[i] += fit.order[j] * tau * (fit.sine[j] * c - fit.cosine[j] * s);
    }
  }
  LeastSquares ls = linear_least_squares(columns, b.value);
  fit.offset = ls.x[0];
  for (std::size_t j = 0; j < k; ++j) {
    fit.cosine[j] = ls.x[1 + 2 * j];
    fit.sine[j] = ls.x[2 + 2 * j];
  }
  const double dof = static_cast<double>(n) - static_cast<double>(columns.size());
  fit.sigma = std::sqrt(ls.chi2 / std::max(dof, 1.0));
  fit.parameters = columns.size();
  fit.covariance = ls.covariance;
  for (double& v : fit.covariance) v *= fit.sigma * fit.sigma;
  return ls;
}

}  // namespace

double HarmonicFit::value(double t) const {
  double v = offset;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double a = 2 * pi * hertz * order[k] * (t - centre);
    v += cosine[k] * std::cos(a) + sine[k] * std::sin(a);
  }
  return v;
}

void HarmonicFit::subtract_from(Signal& s) const {
  constexpr std::size_t run = 256;  // samples for which a phasor is turned before it is set anew
  for (double& v : s.value) v -= offset;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double w = 2 * pi * hertz * order[k];
    const double turn_c = std::cos(w * s.dt), turn_s = std::sin(w * s.dt);
    for (std::size_t first = 0; first < s.size(); first += run) {
      const double a = w * (s.time(first) - centre);
      double c = std::cos(a), d = std::sin(a);
      for (std::size_t i = first; i < std::min(first + run, s.size()); ++i) {
        s.value[i] -= cosine[k] * c + sine[k] * d;
        const double next = c * turn_c - d * turn_s;
        d = d * turn_c + c * turn_s;
        c = next;
      }
    }
  }
}

double HarmonicFit::amplitude(std::size_t k) const {
  return std::hypot(cosine[k], sine[k]);
}

Measured HarmonicFit::phase_at(double t) const {
  const double a2 = cosine[0] * cosine[0] + sine[0] * sine[0];
  if (!(a2 > 0)) return {};
  Measured m;
  m.value = wrap_turn(std::atan2(cosine[0], sine[0]) + 2 * pi * hertz * (t - centre));
  std::vector<double> g(parameters, 0.0);
  g[1] = sine[0] / a2;
  g[2] = -cosine[0] / a2;
  if (parameters > 1 + 2 * order.size()) g.back() = t - centre;
  double v = 0;
  for (std::size_t i = 0; i < parameters; ++i)
    for (std::size_t j = 0; j < parameters; ++j) v += g[i] * covariance[i * parameters + j] * g[j];
  m.u = std::sqrt(std::max(v, 0.0));
  return m;
}

std::optional<HarmonicFit> fit_harmonics(const Signal& s, double t1, double t2, std::vector<int> orders,
                                         double hertz, bool fit_frequency, double min_periods) {
  if (s.empty() || !(hertz > 0)) return std::nullopt;
  const Blocks b = average_blocks(s, t1, t2);
  if (b.time.size() < 4 * (orders.size() + 1) * 2) return std::nullopt;
  const double span = b.time.back() - b.time.front() + b.width * b.dt;
  HarmonicFit fit;
  fit.order = std::move(orders);
  fit.hertz = hertz;
  fit.centre = 0.5 * (b.time.front() + b.time.back());
  fit.cosine.assign(fit.order.size(), 0.0);
  fit.sine.assign(fit.order.size(), 0.0);
  if (span * hertz < min_periods) return std::nullopt;
  solve(b, fit, false);
  for (int i = 0; fit_frequency && i < 12; ++i) {
    const LeastSquares ls = solve(b, fit, true);
    const double dw = ls.x.back();
    if (!ls.converged || !std::isfinite(dw)) return std::nullopt;
    fit.hertz += dw / (2 * pi);
    if (!(fit.hertz > 0.5 * hertz && fit.hertz < 1.5 * hertz)) return std::nullopt;
    if (std::abs(dw) < 1e-9 * 2 * pi * hertz) break;
  }
  if (span * fit.hertz < min_periods) return std::nullopt;
  if (fit_frequency) fit.u_hertz = std::sqrt(std::max(fit.covariance.back(), 0.0)) / (2 * pi);
  return fit;
}

}  // namespace powbench::dsp
