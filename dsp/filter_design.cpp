#include "dsp/filter_design.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/units.h"

namespace powbench::dsp {

namespace {

using Complex = std::complex<double>;

bool uses_low(FilterKind k) {
  return k != FilterKind::low;
}
bool uses_high(FilterKind k) {
  return k != FilterKind::high;
}

void require_edge(const char* key, double hertz, double rate) {
  if (!(hertz > 0) || !(hertz < rate / 2))
    throw std::invalid_argument(std::string(key) + " = " + std::to_string(hertz) + ": allowed 0 .. " +
                                std::to_string(rate / 2) + " Hz, exclusive");
}

void check(const FilterSpec& s) {
  if (s.order < 1 || s.order > 16)
    throw std::invalid_argument("order = " + std::to_string(s.order) + ": allowed 1 .. 16");
  if (!(s.rate > 0) || !std::isfinite(s.rate))
    throw std::invalid_argument("rate = " + std::to_string(s.rate) + ": allowed > 0 Hz");
  if (uses_low(s.kind)) require_edge("low_hertz", s.low_hertz, s.rate);
  if (uses_high(s.kind)) require_edge("high_hertz", s.high_hertz, s.rate);
  if (uses_low(s.kind) && uses_high(s.kind) && !(s.low_hertz < s.high_hertz))
    throw std::invalid_argument("low_hertz = " + std::to_string(s.low_hertz) +
                                ": allowed below high_hertz = " + std::to_string(s.high_hertz));
}

/// Analog edges in rad/s, prewarped and corrected for two passes.
struct Edges {
  double centre = 0;  ///< cut-off, or geometric centre of the band
  double width = 0;   ///< of the band
};

Edges analog_edges(const FilterSpec& s) {
  const auto warp = [&](double f) { return 2 * s.rate * std::tan(pi * f / s.rate); };
  const double widen = s.two_pass ? std::pow(std::sqrt(2.0) - 1.0, -1.0 / (2.0 * s.order)) : 1.0;
  switch (s.kind) {
    case FilterKind::low:
      return {warp(s.high_hertz) * widen, 0};
    case FilterKind::high:
      return {warp(s.low_hertz) / widen, 0};
    default:
      break;
  }
  const double lo = warp(s.low_hertz), hi = warp(s.high_hertz);
  const double width = hi - lo;
  return {std::sqrt(lo * hi), s.kind == FilterKind::band ? width * widen : width / widen};
}

/// Left-half-plane poles of the unit-cut-off prototype: exp(i pi (2k + N + 1) / 2N).
std::vector<Complex> prototype(int order) {
  std::vector<Complex> poles;
  for (int k = 0; k < order; ++k) {
    const double angle = pi * (2.0 * k + order + 1) / (2.0 * order);
    poles.emplace_back(std::cos(angle), 2 * k + 1 == order ? 0.0 : std::sin(angle));
  }
  return poles;
}

std::vector<Complex> analog_poles(const FilterSpec& s, const Edges& e) {
  std::vector<Complex> out;
  for (const Complex p : prototype(s.order)) {
    switch (s.kind) {
      case FilterKind::low:
        out.push_back(p * e.centre);
        break;
      case FilterKind::high:
        out.push_back(e.centre / p);
        break;
      default: {
        const Complex half = s.kind == FilterKind::band ? p * (e.width / 2) : (e.width / 2) / p;
        const Complex root = std::sqrt(half * half - e.centre * e.centre);
        out.push_back(half + root);
        out.push_back(half - root);
      }
    }
  }
  return out;
}

/// Frequency (rad/sample) where the filter has unit gain.
double reference_angle(const FilterSpec& s, const Edges& e) {
  if (s.kind == FilterKind::high) return pi;
  return s.kind == FilterKind::band ? 2 * std::atan(e.centre / (2 * s.rate)) : 0.0;
}

std::vector<Complex> digital_zeros(const FilterSpec& s, const Edges& e) {
  std::vector<Complex> z;
  const double w0 = 2 * std::atan(e.centre / (2 * s.rate));
  for (int k = 0; k < s.order; ++k) {
    switch (s.kind) {
      case FilterKind::low:
        z.emplace_back(-1.0);
        break;
      case FilterKind::high:
        z.emplace_back(1.0);
        break;
      case FilterKind::band:
        z.insert(z.end(), {Complex(1.0), Complex(-1.0)});
        break;
      case FilterKind::stop:
        z.insert(z.end(), {std::polar(1.0, w0), std::polar(1.0, -w0)});
        break;
    }
  }
  return z;
}

Complex evaluate(const Section& q, Complex z) {
  const Complex v = 1.0 / z;
  return (q.b0 + v * (q.b1 + v * q.b2)) / (1.0 + v * (q.a1 + v * q.a2));
}

/// Poles as (p1, p2) of one section each: conjugates together, then real poles two by two, largest radius
/// first.
std::vector<std::pair<Complex, Complex>> pole_pairs(const std::vector<Complex>& poles) {
  std::vector<std::pair<Complex, Complex>> pairs;
  std::vector<double> real;
  for (const Complex p : poles) {
    if (std::abs(p.imag()) < 1e-14 * std::abs(p))
      real.push_back(p.real());
    else if (p.imag() > 0)
      pairs.emplace_back(p, std::conj(p));
  }
  std::sort(real.begin(), real.end());
  for (std::size_t i = 0; i + 1 < real.size(); i += 2) pairs.emplace_back(real[i], real[i + 1]);
  if (real.size() % 2) pairs.emplace_back(real.back(), Complex(0.0));
  std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
    return std::abs(a.first) * (a.second == 0.0 ? 0.0 : 1.0) >
           std::abs(b.first) * (b.second == 0.0 ? 0.0 : 1.0);
  });
  return pairs;
}

}  // namespace

Zpk design_butterworth(const FilterSpec& s) {
  check(s);
  const Edges e = analog_edges(s);
  Zpk out;
  out.zeros = digital_zeros(s, e);
  const double c = 2 * s.rate;
  for (const Complex p : analog_poles(s, e)) out.poles.push_back((c + p) / (c - p));
  const Complex z = std::polar(1.0, reference_angle(s, e));
  Complex h = 1.0;
  for (std::size_t i = 0; i < out.poles.size(); ++i) h *= (z - out.zeros[i]) / (z - out.poles[i]);
  out.gain = 1.0 / std::abs(h);
  return out;
}

std::vector<Section> to_sections(const FilterSpec& s) {
  const Zpk zpk = design_butterworth(s);
  const Edges e = analog_edges(s);
  const Complex at = std::polar(1.0, reference_angle(s, e));
  const double stop_cos = std::cos(2 * std::atan(e.centre / (2 * s.rate)));
  std::vector<Section> out;
  for (const auto& [p1, p2] : pole_pairs(zpk.poles)) {
    const bool single = p2 == Complex(0.0);
    Section q;
    q.a1 = -(p1 + p2).real();
    q.a2 = (p1 * p2).real();
    switch (s.kind) {
      case FilterKind::low:
        q.b1 = single ? 1 : 2, q.b2 = single ? 0 : 1;
        break;
      case FilterKind::high:
        q.b1 = single ? -1 : -2, q.b2 = single ? 0 : 1;
        break;
      case FilterKind::band:
        q.b1 = 0, q.b2 = -1;
        break;
      case FilterKind::stop:
        q.b1 = -2 * stop_cos, q.b2 = 1;
        break;
    }
    const double g = 1.0 / std::abs(evaluate(q, at));
    q.b0 *= g, q.b1 *= g, q.b2 *= g;
    out.push_back(q);
  }
  return out;
}

std::complex<double> response(const std::vector<Section>& sections, double hertz, double rate) {
  const Complex z = std::polar(1.0, 2 * pi * hertz / rate);
  Complex h = 1.0;
  for (const Section& q : sections) h *= evaluate(q, z);
  return h;
}

}  // namespace powbench::dsp
