#include "dsp/contacts/contact_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.h"
#include "dsp/contacts/pulse_margin.h"
#include "dsp/signal/least_squares.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

std::uint32_t flags_of_mask(const Signal& s, double t1, double t2) {
  const std::uint8_t m = s.mask_within(t1, t2);
  return (m & mask_clipped ? flag_clipped : 0U) | (m & mask_gap ? flag_gap : 0U) |
         (m & mask_edge ? flag_edge : 0U);
}

/// What a sampled edge leaves open whatever the noise: the force between samples and the amplifier's own rise. A full
/// dt / sqrt(12) for an edge of five samples or fewer, less in proportion for longer ones.
double shape_uncertainty(double dt, double rise) {
  return dt / std::sqrt(12.0) * std::min(1.0, 5 * dt / std::max(rise, dt));
}

PulseGradient pulse_gradient(const PulseShape& f, double t) {
  const double width = f.release - f.touch, v = (t - f.touch) / width;
  if (!(v > 0) || !(v < 1)) return {};
  const double w = f.skew == 1.0 ? v : std::pow(v, f.skew);
  const double base = std::max(std::sin(pi * w), 1e-3);
  const double power = std::pow(base, f.exponent);
  const double slope = f.peak * f.exponent * power / base * pi * std::cos(pi * w);
  const double by_v = slope * f.skew * w / v;
  return {by_v * (v - 1) / width, -by_v * v / width, power, f.peak * power * std::log(base),
          slope * w * std::log(v) * f.skew};
}

namespace {

constexpr double skew_prior_sigma = 0.3;  ///< of ln(skew), around 0

struct Samples {
  std::vector<double> t, x;
};

Samples good_samples(const Signal& s, double t1, double t2) {
  Samples out;
  for (std::size_t i = s.index_at(t1); i < s.size() && s.time(i) <= t2; ++i) {
    if (s.masked[i]) continue;
    out.t.push_back(s.time(i));
    out.x.push_back(s.value[i]);
  }
  return out;
}

/// Means of `per_row` neighbours, so that about `rows` are left; a row that a clipped or lost sample would part is
/// left out.
Samples thinned(const Samples& s, std::size_t rows, double dt, std::size_t& per_row) {
  per_row = std::max<std::size_t>(1, s.t.size() / rows);
  if (per_row == 1) return s;
  const double longest = (static_cast<double>(per_row) - 0.5) * dt;
  Samples out;
  for (std::size_t i = 0; i + per_row <= s.t.size(); i += per_row) {
    if (s.t[i + per_row - 1] - s.t[i] > longest) continue;
    double t = 0, x = 0;
    for (std::size_t k = i; k < i + per_row; ++k) t += s.t[k], x += s.x[k];
    out.t.push_back(t / static_cast<double>(per_row));
    out.x.push_back(x / static_cast<double>(per_row));
  }
  return out;
}

bool outside_band(double reduced, double dof, double confidence) {
  if (dof < 1) return true;
  return reduced > reduced_chi2_quantile(0.5 + 0.5 * confidence, dof);
}

struct PulseFit {
  LeastSquares ls;
  PulseShape shape;
  double chi2 = 0, dof = 0;
  double reduced() const { return chi2 / std::max(dof, 1.0); }
};

/// Parameters relative to the start: times in units of the width, force in units of the start's peak.
PulseFit fit_pulse(const Samples& s, const PulseShape& start, double noise, const ExtractOptions& o,
                   bool skewed, int iterations = 40) {
  const double width = start.release - start.touch;
  const auto shape_of = [&](std::span<const double> q) {
    return PulseShape{start.touch + q[0] * width, start.release + q[1] * width, start.peak * q[2], q[3],
                      skewed ? std::exp(q[4]) : 1.0};
  };
  const double reach = std::max(0.45, 100e-6 / width);
  std::vector<FreeParameter> p{{0, 1e-4, -reach, 0.45},
                               {0, 1e-4, -0.45, reach},
                               {1, 1e-4, 0.05, 10},
                               {start.exponent, 1e-4, o.exponent_min, o.exponent_max}};
  if (skewed) p.push_back({std::log(start.skew), 1e-4, -1.5, 1.5});
  const std::size_t priors = skewed ? 2 : 1;
  const auto residuals = [&](std::span<const double> q, std::span<double> r) {
    const PulseShape f = shape_of(q);
    const std::size_t n = s.t.size();
    for (std::size_t i = 0; i < n; ++i) r[i] = (f(s.t[i]) - s.x[i]) / noise;
    r[n] = (q[3] - exponent_prior) / exponent_prior_sigma;
    if (skewed) r[n + 1] = q[4] / skew_prior_sigma;
  };
  const auto derivatives = [&](std::span<const double> q, std::span<double> j) {
    const std::size_t n = s.t.size(), rows = n + priors;
    std::fill(j.begin(), j.end(), 0.0);
    const PulseShape f = shape_of(q);
    for (std::size_t i = 0; i < n; ++i) {
      const auto d = pulse_gradient(f, s.t[i]);
      j[i] = d.touch * width / noise;
      j[rows + i] = d.release * width / noise;
      j[2 * rows + i] = d.peak * start.peak / noise;
      j[3 * rows + i] = d.exponent / noise;
      if (skewed) j[4 * rows + i] = d.log_skew / noise;
    }
    j[3 * rows + n] = 1 / exponent_prior_sigma;
    if (skewed) j[4 * rows + n + 1] = 1 / skew_prior_sigma;
  };
  PulseFit fit;
  fit.ls = levenberg_marquardt(residuals, s.t.size() + priors, p, iterations, derivatives);
  fit.shape = shape_of(fit.ls.x);
  fit.dof = static_cast<double>(s.t.size()) - static_cast<double>(p.size());
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double e = (fit.shape(s.t[i]) - s.x[i]) / noise;
    fit.chi2 += e * e;
  }
  return fit;
}

/// Trapezoid over the samples inside; the kinks' own error is negligible beside the noise.
Measured impulse_of(const Signal& s, double t1, double t2, double noise) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t i = s.index_at(t1); i < s.size() && s.time(i) <= t2; ++i, ++n) sum += s.value[i];
  return {sum * s.dt, noise * s.dt * std::sqrt(static_cast<double>(std::max<std::size_t>(n, 1)))};
}

double largest(std::span<const double> smooth, const Signal& s, double t1, double t2) {
  double peak = 0;
  for (std::size_t i = s.index_at(t1); i < s.size() && s.time(i) <= t2; ++i) peak = std::max(peak, smooth[i]);
  return peak;
}

/// Birge: where the model does not reach the noise, the uncertainty grows with the misfit.
double birge(double reduced) {
  return std::sqrt(std::max(reduced, 1.0));
}

/// Time of the first maximum of the smoothed force seen from the kink inwards, at most `span` away.
double first_maximum(const FitInput& in, double kink, int side, double span) {
  const Signal& s = in.force;
  const auto step = static_cast<std::ptrdiff_t>(side);
  auto i = static_cast<std::ptrdiff_t>(s.index_at(kink));
  const auto n = static_cast<std::ptrdiff_t>(s.size());
  double best = -1e300, at = kink;
  for (; i >= 0 && i < n; i += step) {
    const double t = s.time(static_cast<std::size_t>(i)), v = in.smooth[static_cast<std::size_t>(i)];
    if (std::abs(t - kink) > span) return kink + side * span;
    if (v > best) best = v, at = t;
    if (v < best - std::max(5 * in.levels.noise, 0.05 * best)) break;
  }
  return at;
}

struct EdgeCandidate {
  LeastSquares ls;
  double chi2 = 0;
  std::function<double(double)> shape;
  double peak = 0;
};

/// v = side (t - kink); rise = sine power over `length`, or exponential with constant `length`.
EdgeCandidate fit_edge_family(const Samples& s, double kink, int side, double length, double peak,
                              double noise, const ExtractOptions& o, bool exponential) {
  const auto shape_of = [=](double a, double l, double f, double q) {
    return [=](double t) {
      const double v = side * (t - a) / l;
      if (v <= 0) return 0.0;
      if (exponential) return f * (-std::expm1(-v)) + q * f * v;
      return v >= 1 ? f : f * std::pow(std::sin(0.5 * pi * v), q);
    };
  };
  const auto from = [&](std::span<const double> q) {
    return shape_of(kink + q[0] * length, length * std::exp(q[1]), peak * q[2], q[3]);
  };
  const std::vector<FreeParameter> p{
      {0, 1e-4, -2.0, 1.0},
      {exponential ? -1.0 : 0.0, 1e-4, exponential ? -4.0 : -0.7, exponential ? 1.5 : 0.7},
      {1, 1e-4, 0.02, 20},
      exponential ? FreeParameter{0, 1e-4, -1, 3} : FreeParameter{1.1, 1e-4, o.exponent_min, o.exponent_max}};
  const std::size_t n = s.t.size();
  const auto residuals = [&](std::span<const double> q, std::span<double> r) {
    const auto f = from(q);
    for (std::size_t i = 0; i < n; ++i) r[i] = (f(s.t[i]) - s.x[i]) / noise;
    r[n] = exponential ? q[3] / 0.5 : (q[3] - exponent_prior) / exponent_prior_sigma;
  };
  const auto derivatives = [&](std::span<const double> q, std::span<double> j) {
    std::fill(j.begin(), j.end(), 0.0);
    const double a = kink + q[0] * length, l = length * std::exp(q[1]), f = peak * q[2], rows = 1 / noise;
    for (std::size_t i = 0; i < n; ++i) {
      const double v = side * (s.t[i] - a) / l;
      if (v <= 0) continue;
      double by_v = 0, by_peak = 0, by_last = 0;  // of F; F / peak; last parameter
      if (exponential) {
        const double e = std::exp(-v);
        by_v = f * (e + q[3]), by_peak = 1 - e + q[3] * v, by_last = f * v;
      } else if (v < 1) {
        const double sine = std::max(std::sin(0.5 * pi * v), 1e-6), power = std::pow(sine, q[3]);
        by_v = f * q[3] * power / sine * 0.5 * pi * std::cos(0.5 * pi * v);
        by_peak = power, by_last = f * power * std::log(sine);
      } else {
        by_peak = 1;
      }
      const std::array<double, 4> by{-side * length / l * by_v, -v * by_v, peak * by_peak, by_last};
      for (std::size_t k = 0; k < by.size(); ++k) j[k * (n + 1) + i] = by[k] * rows;
    }
    j[3 * (n + 1) + n] = 1 / (exponential ? 0.5 : exponent_prior_sigma);
  };
  EdgeCandidate c;
  c.ls = levenberg_marquardt(residuals, n + 1, p, 40, derivatives);
  const auto f = from(c.ls.x);
  for (std::size_t i = 0; i < n; ++i) {
    const double e = (f(s.t[i]) - s.x[i]) / noise;
    c.chi2 += e * e;
  }
  c.shape = f;
  c.peak = peak * c.ls.x[2];
  return c;
}

}  // namespace

Contact contact_from(const PulseShape& p, const Measured& touch, const Measured& release,
                     const Measured& peak, const Signal& force, double noise, double grow) {
  Contact c;
  const double floor = shape_uncertainty(force.dt, 0.5 * (p.release - p.touch));
  c.touch = {touch.value, std::hypot(touch.u * grow, floor)};
  c.release = {release.value, std::hypot(release.u * grow, floor)};
  c.peak = {peak.value, peak.u * grow};
  c.impulse = impulse_of(force, touch.value, release.value, noise);
  c.flags = flags_of_mask(force, touch.value, release.value);
  return c;
}

double PulseShape::operator()(double t) const {
  const double v = (t - touch) / (release - touch);
  if (!(v > 0) || !(v < 1)) return 0.0;
  const double base = std::sin(pi * (skew == 1.0 ? v : std::pow(v, skew)));
  return base > 0 ? peak * (exponent == 1.0 ? base : std::pow(base, exponent)) : 0.0;
}

EdgeFit fit_edge(const FitInput& in, double kink, int side, double open_span, double closed_span) {
  const double top = first_maximum(in, kink, side, closed_span);
  const double dt = in.force.dt;
  const double length = std::max(std::abs(top - kink), 3 * dt);
  const double inner = kink + side * std::max(length, 4 * dt);
  const double outer = kink - side * open_span;
  const Samples s = good_samples(in.force, std::min(inner, outer), std::max(inner, outer));
  EdgeFit e;
  e.kink = {kink, std::max(in.levels.width, dt)};
  e.poor = true;
  const double dof = static_cast<double>(s.t.size()) - 4.0;
  if (dof < 2) return e;
  const double peak =
      std::max(largest(in.smooth, in.force, std::min(kink, inner), std::max(kink, inner)), in.levels.touch);
  EdgeCandidate best = fit_edge_family(s, kink, side, length, peak, in.noise, in.options, false);
  EdgeCandidate other = fit_edge_family(s, kink, side, length, peak, in.noise, in.options, true);
  if (other.chi2 < best.chi2) best = std::move(other);
  e.reduced_chi2 = best.chi2 / dof;
  e.poor = outside_band(e.reduced_chi2, dof, in.options.chi2_confidence);
  const double u = best.ls.u(0) * length * birge(e.reduced_chi2);
  if (std::isfinite(u)) e.kink = {kink + best.ls.x[0] * length, std::hypot(u, shape_uncertainty(dt, length))};
  e.peak = best.peak;
  e.shape = best.shape;
  return e;
}

namespace {

ContactFit fit_by_edges(const FitInput& in, const Interval& c, const Neighbours& nb) {
  const ExtractOptions& o = in.options;
  ContactFit out;
  const double closed = c.open_ended() ? o.edge_window : std::min(o.edge_window, 0.7 * (c.release - c.touch));
  const double before = std::clamp(0.6 * (c.touch - nb.previous_release), 3 * in.force.dt, o.fit_margin);
  const EdgeFit touch = fit_edge(in, c.touch, +1, before, closed);
  out.contact.touch = touch.kink;
  out.reduced_chi2 = touch.reduced_chi2;
  if (touch.poor) out.contact.flags |= flag_poor_fit;
  const double stop = c.open_ended() ? c.touch + o.edge_window : c.release;
  if (!c.open_ended()) {
    const double after = std::clamp(0.6 * (nb.next_touch - c.release), 3 * in.force.dt, o.fit_margin);
    const EdgeFit release = fit_edge(in, c.release, -1, after, closed);
    out.contact.release = release.kink;
    if (release.poor) out.contact.flags |= flag_poor_fit;
    if (!(out.contact.release.value > out.contact.touch.value)) {  // the edges ran into each other
      out.contact.touch = {c.touch, in.levels.width};
      out.contact.release = {c.release, in.levels.width};
      out.contact.flags |= flag_poor_fit;
    }
    out.contact.impulse = impulse_of(in.force, out.contact.touch.value, out.contact.release.value, in.noise);
  }
  out.contact.peak = {largest(in.smooth, in.force, c.touch, stop), in.levels.noise};
  out.contact.flags |= flags_of_mask(in.force, c.touch, stop);
  return out;
}

}  // namespace

namespace {

ContactFit coarse_contact(const FitInput& in, const Interval& c) {
  ContactFit out;
  out.contact.touch = {c.touch, in.levels.width};
  if (!c.open_ended()) out.contact.release = {c.release, in.levels.width};
  const double stop = c.open_ended() ? c.touch + in.options.edge_window : c.release;
  out.contact.peak = {largest(in.smooth, in.force, c.touch, stop), in.levels.noise};
  out.contact.flags = flag_poor_fit;
  return out;
}

/// A long contact that no pulse comes near, even with skew, found on a few rows at a fraction of the price of its fit.
bool no_pulse(const Samples& s, const PulseShape& guess, const FitInput& in) {
  constexpr std::size_t rows = 60;
  constexpr double hopeless = 6;  // reduced sum of squares of the samples; 3 is given up
  std::size_t per_row = 1;
  const Samples few = thinned(s, rows, in.force.dt, per_row);
  if (in.quick || per_row < 3 || 2 * few.t.size() < rows) return false;
  const double n = static_cast<double>(per_row), mixed = 2e-3 * guess.peak,  // rows across an edge
      noise = std::hypot(in.noise / std::sqrt(n), mixed);
  const auto left = [&](const PulseFit& f) { return 1 + (f.reduced() - 1) / n; };
  const PulseFit plain = fit_pulse(few, guess, noise, in.options, false);
  return left(plain) >= hopeless && left(fit_pulse(few, plain.shape, noise, in.options, true)) >= hopeless;
}

}  // namespace

ContactFit fit_contact(const FitInput& in, const Interval& c, const Neighbours& nb) {
  if (c.open_ended()) return in.quick ? coarse_contact(in, c) : fit_by_edges(in, c, nb);
  const ExtractOptions& o = in.options;
  const double dt = in.force.dt;
  const double before = std::clamp(0.45 * (c.touch - nb.previous_release), 3 * dt, o.fit_margin);
  const double after = std::clamp(0.45 * (nb.next_touch - c.release), 3 * dt, o.fit_margin);
  const Samples s = good_samples(in.force, c.touch - before, c.release + after);
  if (s.t.size() < 7) return in.quick ? coarse_contact(in, c) : fit_by_edges(in, c, nb);
  const double peak = std::max(largest(in.smooth, in.force, c.touch, c.release), in.levels.touch);
  const PulseShape guess{c.touch, c.release, peak, 1.2, 1.0};
  // of a clipped contact only the pulse knows the peak
  const bool clipped = (flags_of_mask(in.force, c.touch, c.release) & flag_clipped) != 0;
  if (!clipped && no_pulse(s, guess, in)) return fit_by_edges(in, c, nb);
  PulseFit best = fit_pulse(s, guess, in.noise, o, false, in.quick ? 10 : 40);
  if (!in.quick && outside_band(best.reduced(), best.dof, o.chi2_confidence) && s.t.size() > 8) {
    const PulseFit skewed = fit_pulse(s, best.shape, in.noise, o, true);
    if (skewed.chi2 + std::log(static_cast<double>(s.t.size())) < best.chi2) best = skewed;
  }
  const bool poor = outside_band(best.reduced(), best.dof, o.chi2_confidence);
  ContactFit out;
  if (poor && best.reduced() > 3.0) {
    return in.quick ? coarse_contact(in, c) : fit_by_edges(in, c, nb);
  }
  const double width = c.release - c.touch, b = birge(best.reduced());
  const double floor = shape_uncertainty(dt, 0.5 * width);
  out.contact.touch = {best.shape.touch, std::hypot(best.ls.u(0) * width * b, floor)};
  out.contact.release = {best.shape.release, std::hypot(best.ls.u(1) * width * b, floor)};
  out.contact.peak = {best.shape.peak, best.ls.u(2) * peak * b};
  if (!in.quick && !(best.ls.u(3) < open_exponent)) {
    const PulseMargin m =
        over_exponents(in.force, in.noise, best.shape, c.touch - before, c.release + after, o);
    if (m.known) use_margin(out.contact, m, b);
  }
  out.contact.impulse = impulse_of(in.force, best.shape.touch, best.shape.release, in.noise);
  out.contact.flags = flags_of_mask(in.force, c.touch, c.release) | (poor ? flag_poor_fit : 0U);
  out.shape = best.shape;
  out.reduced_chi2 = best.reduced();
  return out;
}

}  // namespace powbench::dsp
