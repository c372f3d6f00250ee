#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <map>
#include <utility>

#include "core/units.h"
#include "dsp/signal/fft.h"
#include "dsp/signal/statistics.h"
#include "dsp/vibration/ring.h"
#include "dsp/vibration/ring_rows.h"

namespace powbench::dsp {

namespace {

/// Energy of `x` along exp(s t) at the usable rows, as a share that a fit of both phases would take out.
double explained(const RingRows& r, const std::vector<double>& x, const Pole& p) {
  const std::complex<double> turn = std::exp(pole_s(p) * r.dt);
  std::complex<double> e = 1.0;
  double cc = 0, ss = 0, cs = 0, cx = 0, sx = 0;
  for (std::size_t i = 0; i < x.size(); ++i, e *= turn) {
    if (!r.good[i]) continue;
    const double c = e.real(), s = e.imag();
    cc += c * c, ss += s * s, cs += c * s, cx += c * x[i], sx += s * x[i];
  }
  const double det = cc * ss - cs * cs;
  if (!(det > 1e-9 * cc * ss)) return 0.0;
  return (ss * cx * cx - 2 * cs * cx * sx + cc * sx * sx) / det;
}

/// Largest |sum x exp(-s t)|^2 / sum exp(-2 decay t) over a grid of three decays and all frequencies: one transform
/// each.
Pole coarse_pole(const RingRows& r, const std::vector<double>& x, double low, double high) {
  const std::size_t n = std::bit_ceil(std::max<std::size_t>(2 * x.size(), 512));
  thread_local std::map<std::size_t, RealFft>
      plans;  // planning costs more than the transform; few lengths occur
  RealFft& fft = plans.try_emplace(n, n).first->second;
  const double bin = 1.0 / (static_cast<double>(n) * r.dt);
  Pole at;
  double best = 0;
  for (const double decay : {100.0, 400.0, 1600.0}) {
    const double turn = std::exp(-decay * r.dt);
    double weight = 1, energy = 0;
    const auto time = fft.time();
    std::fill(time.begin(), time.end(), 0.0);
    for (std::size_t i = 0; i < x.size(); ++i, weight *= turn) {
      if (!r.good[i]) continue;
      time[i] = weight * x[i];
      energy += weight * weight;
    }
    if (!(energy > 0)) continue;
    fft.forward();
    const auto spectrum = fft.spectrum();
    for (std::size_t k = 1; k + 1 < spectrum.size(); ++k) {
      const double hertz = static_cast<double>(k) * bin;
      if (hertz < low || hertz > high || decay > 0.12 * 2 * pi * hertz) continue;
      const double gain = std::norm(spectrum[k]) / energy;
      if (gain > best) best = gain, at = {hertz, decay};
    }
  }
  return at;
}

}  // namespace

std::optional<Pole> strongest_pole(const RingInput& in, const Ring& ring, const ExtractOptions& o,
                                   double* gain) {
  RingRows r = ring_rows(in.residual, &in.usable, in.from, in.to);
  const double noise = in.noise / std::sqrt(r.block);
  const auto good = static_cast<double>(std::count(r.good.begin(), r.good.end(), std::uint8_t{1}));
  if (good < 40) return std::nullopt;
  // What the present model leaves.
  for (std::size_t i = 0; i < r.t.size(); ++i) r.y[i] -= ring.value(r.t[i]);
  const std::vector<double> x = without_smooth(r, in.closed_from, in.to);
  const double high = std::min(o.ring_high_hertz, 0.45 / r.dt);
  double best = 0;
  Pole at = coarse_pole(r, x, o.ring_low_hertz, high);
  if (at.hertz == 0) return std::nullopt;
  const auto look = [&](double hertz, double damping) {
    const Pole p{hertz, damping * 2 * pi * hertz};
    if (const double g = explained(r, x, p); g > best) best = g, at = p;
  };
  const double centre = at.hertz, step = std::max(20.0, 0.006 * centre);
  for (const double damping : {0.005, 0.01, 0.015, 0.02, 0.03})
    for (int k = -2; k <= 2; ++k) look(centre + 0.5 * k * step, damping);
  if (gain) *gain = best;
  // Of a few hundred trials on pure noise the largest gain is about 2 ln(trials) = 12; ask for clearly more.
  return best > 40 * noise * noise ? std::optional(at) : std::nullopt;
}

namespace {

std::vector<Pole> poles_of(const Ring& ring) {
  std::vector<Pole> p;
  for (const RingMode& m : ring.modes) p.push_back(m.pole);
  return p;
}

/// Modes that are larger than anything in the data cancel each other there: the fit says nothing elsewhere.
bool plausible(const RingInput& in, const Ring& ring) {
  double largest = 0;
  for (std::size_t i = in.residual.index_at(in.from); i < in.residual.index_at(in.closed_from); ++i)
    if (in.usable[i] && !in.residual.masked[i]) largest = std::max(largest, std::abs(in.residual.value[i]));
  if (largest == 0) return true;  // only the tail is used: the settled force hides the scale
  return std::all_of(ring.modes.begin(), ring.modes.end(),
                     [&](const RingMode& m) { return std::hypot(m.cosine, m.sine) < 3 * largest; });
}

}  // namespace

Ring grow_ring(const RingInput& in, std::vector<Pole> start, const ExtractOptions& o, double* reduced,
               double hopeless) {
  // Two close modes fitted by one look heavily damped, so that the limit is held only at the end.
  ExtractOptions loose = o;
  loose.ring_damping_max = std::max(o.ring_damping_max, 0.12);
  Ring ring = fit_ring(in, start, loose, reduced, hopeless);
  if (ring.empty() && !start.empty() && std::isfinite(hopeless)) return ring;
  while (start.size() > 1 && !plausible(in, ring)) {  // without the most damped one
    const auto worst = std::max_element(start.begin(), start.end(), [](const Pole& a, const Pole& b) {
      return a.decay / a.hertz < b.decay / b.hertz;
    });
    start.erase(worst);
    ring = fit_ring(in, start, loose, reduced);
  }
  while (static_cast<int>(ring.modes.size()) < o.ring_modes) {
    const auto more = strongest_pole(in, ring, o);
    if (!more) break;
    std::vector<Pole> poles = poles_of(ring);
    poles.push_back(*more);
    double left = 0;
    Ring next = fit_ring(in, std::move(poles), loose, &left);
    if (next.modes.size() <= ring.modes.size() || !plausible(in, next)) break;
    ring = std::move(next);
    if (reduced) *reduced = left;
  }
  const bool strict = std::all_of(ring.modes.begin(), ring.modes.end(), [&](const RingMode& m) {
    return m.pole.decay <= o.ring_damping_max * 2 * pi * m.pole.hertz;
  });
  return strict ? ring : fit_ring(in, poles_of(ring), o, reduced);
}

double find_onset(const Signal& signal, const std::vector<std::uint8_t>* usable, const Ring& ring, double t1,
                  double t2, double slow) {
  Ring everywhere = ring;
  everywhere.onset = t1;
  const RingRows f = ring_rows(signal, usable, t1, t2);
  if (f.t.size() < 4) return t2;
  std::vector<double> x = f.y, r(f.t.size());
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = everywhere.value(f.t[i]);
  if (!usable) {
    // Both through the same high-pass, so that the slow part of the contact force does not count.
    const double width = slow / f.dt;
    const auto f_low = gaussian_smooth(x, width), r_low = gaussian_smooth(r, width);
    for (std::size_t i = 0; i < r.size(); ++i) x[i] -= f_low[i], r[i] -= r_low[i];
  }
  double best = 0, sum = 0, at = t2;
  for (std::size_t i = r.size(); i-- > 0;) {
    if (!f.good[i]) continue;
    const double level = ring.amplitude_at(f.t[i]) + 1e-12;
    const double weight =
        1.0 / (level * level + x[i] * x[i]);  // a contact pulse must not outvote the open time
    sum += weight * ((x[i] - r[i]) * (x[i] - r[i]) - x[i] * x[i]);
    if (sum < best) best = sum, at = f.t[i] - 0.5 * f.dt;
  }
  return at;
}

}  // namespace powbench::dsp
