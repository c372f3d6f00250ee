#include "dsp/filter/bands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/units.h"

namespace powbench::dsp {

namespace {

/// Energy density of a half sine against u = f T, up to a constant: (cos(pi u) / (1 - 4 u^2))^2.
double half_sine_density(double u) {
  const double d = 1 - 4 * u * u;
  if (std::abs(d) < 1e-6) return pi * pi / 16;
  const double v = std::cos(pi * u) / d;
  return v * v;
}

std::vector<bool> coherent_bins(const Coherence& c, double threshold) {
  const std::size_t n = c.value.size();
  std::vector<bool> above(n), core(n);
  for (std::size_t k = 1; k < n; ++k) above[k] = c.value[k] > threshold;  // the mean was removed: no bin 0
  for (std::size_t k = 1; k < n; ++k) core[k] = above[k] && (above[k - 1] || (k + 1 < n && above[k + 1]));
  return core;
}

std::string sentence(const BandReport& r) {
  char text[200];
  std::snprintf(text, sizeof text,
                "core vibration and contact force overlap: %.1f dB of the vibration lies below %.0f Hz; "
                "use the canceller or the joint fit",
                r.ring_in_contact_db, r.contact.high);
  return text;
}

}  // namespace

double decibel(double share) {
  return share > 0 ? 10 * std::log10(std::min(share, 1.0)) : -std::numeric_limits<double>::infinity();
}

double half_sine_energy_below(double hertz, double width) {
  // Simpson's rule; the total, the integral of the density over u = 0 .. infinity, is pi^2 / 16.
  const double end = hertz * width;
  if (!(end > 0)) return 0;
  const int pieces = 2 * std::clamp(static_cast<int>(end * 64), 32, 20000);
  const double h = end / pieces;
  double sum = half_sine_density(0) + half_sine_density(end);
  for (int i = 1; i < pieces; ++i) sum += (i % 2 ? 4 : 2) * half_sine_density(i * h);
  return std::min(1.0, sum * h / 3 / (pi * pi / 16));
}

double half_sine_taken_db(const std::function<double(double)>& gain, double width) {
  constexpr int pieces = 4000;
  constexpr double end = 8;  // over the width
  double all = 0, left = 0;
  for (int i = 0; i < pieces; ++i) {
    const double u = end * (i + 0.5) / pieces, density = half_sine_density(u), g = gain(u / width);
    all += density;
    left += density * std::min(g * g, 1.0);
  }
  const double beyond = all * (1 / half_sine_energy_below(end, 1.0) - 1);
  return decibel((all - left + beyond) / (all + beyond));
}

BandOverlapError::BandOverlapError(const BandReport& r) : std::runtime_error(sentence(r)) {}

BandReport find_bands(const Coherence& c, const BandQuestion& q) {
  if (!(q.pulse_width > 0)) throw std::invalid_argument("pulse_width: allowed > 0 s");
  BandReport out;
  out.closings = c.averages;
  out.threshold = coherence_threshold(c.averages, q.probability);
  out.contact = {0, 1.5 / q.pulse_width};
  const auto core = coherent_bins(c, out.threshold);
  double ring = 0, ring_inside = 0, pulse = 0;
  for (std::size_t k = 0; k < core.size(); ++k) {
    if (!core[k]) continue;
    const double f = c.bin_hertz * static_cast<double>(k), low = f - c.bin_hertz / 2,
                 high = f + c.bin_hertz / 2;
    if (!out.core.empty() && core[k - 1])
      out.core.back().high = high;
    else
      out.core.push_back({low, high});
    const double power = c.value[k] * c.y.density[k];
    ring += power;
    if (f <= out.contact.high) ring_inside += power;
    pulse += half_sine_energy_below(high, q.pulse_width) - half_sine_energy_below(low, q.pulse_width);
  }
  out.ring_in_contact_db = decibel(ring > 0 ? ring_inside / ring : 0);
  out.pulse_in_core_db = decibel(pulse);
  out.overlaps = out.ring_in_contact_db > q.overlap_limit;
  return out;
}

FilterSpec plain_filter(const BandReport& r, double rate) {
  if (r.overlaps) throw BandOverlapError(r);
  return {FilterKind::low, 6, 0, r.contact.high, rate, true, FilterFamily::elliptic, 0.1, 40};
}

}  // namespace powbench::dsp
