#include "dsp/filter_order.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/units.h"
#include "dsp/elliptic.h"
#include "dsp/prototype.h"

namespace powbench::dsp {

namespace {

bool has_two_edges(FilterKind k) {
  return k == FilterKind::band || k == FilterKind::stop;
}

void require_rising(const char* key, double value, double below, double above) {
  if (!(value > below) || !(value < above))
    throw FilterDesignError(key, value,
                            "between " + std::to_string(below) + " and " + std::to_string(above) + " Hz");
}

void check(const FilterRequirement& r) {
  if (!(r.rate > 0) || !std::isfinite(r.rate)) throw FilterDesignError("rate", r.rate, "> 0 Hz");
  const double nyquist = r.rate / 2;
  switch (r.kind) {
    case FilterKind::low:
      require_rising("stop_low", r.stop_low, 0, nyquist);
      require_rising("pass_low", r.pass_low, 0, r.stop_low);
      break;
    case FilterKind::high:
      require_rising("pass_low", r.pass_low, 0, nyquist);
      require_rising("stop_low", r.stop_low, 0, r.pass_low);
      break;
    case FilterKind::band:
      require_rising("pass_low", r.pass_low, 0, nyquist);
      require_rising("stop_low", r.stop_low, 0, r.pass_low);
      require_rising("pass_high", r.pass_high, r.pass_low, nyquist);
      require_rising("stop_high", r.stop_high, r.pass_high, nyquist);
      break;
    case FilterKind::stop:
      require_rising("stop_low", r.stop_low, 0, nyquist);
      require_rising("pass_low", r.pass_low, 0, r.stop_low);
      require_rising("stop_high", r.stop_high, r.stop_low, nyquist);
      require_rising("pass_high", r.pass_high, r.stop_high, nyquist);
      break;
  }
  if (!(r.pass_db >= 1e-6) || !(r.pass_db <= 20))
    throw FilterDesignError("pass_db", r.pass_db, "1e-6 .. 20 dB");
  if (!(r.stop_db > 1.5 * r.pass_db) || !(r.stop_db <= 240))
    throw FilterDesignError("stop_db", r.stop_db, "above 1.5 pass_db, up to 240 dB");
}

/// Prewarped edges.
struct Warped {
  double p1, p2, s1, s2;
};

/// Stop-band edge of the low-pass prototype whose pass-band edge is 1.
double selectivity(FilterKind kind, const Warped& w) {
  if (kind == FilterKind::low) return w.s1 / w.p1;
  if (kind == FilterKind::high) return w.p1 / w.s1;
  const double centre2 = w.p1 * w.p2, width = w.p2 - w.p1;
  const auto map = [&](double s) {
    const double v = std::abs((s * s - centre2) / (s * width));
    return kind == FilterKind::band ? v : 1 / v;
  };
  return std::min(map(w.s1), map(w.s2));
}

double real_order(FilterFamily family, double discrimination, double edge) {
  switch (family) {
    case FilterFamily::butterworth:
      return std::log(discrimination) / std::log(edge);
    case FilterFamily::chebyshev1:
    case FilterFamily::chebyshev2:
      return std::acosh(discrimination) / std::acosh(edge);
    case FilterFamily::elliptic:
      break;
  }
  const double k = 1 / edge, kc = std::sqrt((1 - k) * (1 + k));
  const double k1 = 1 / discrimination, k1c = std::sqrt((1 - k1) * (1 + k1));
  return complete_integral(kc) * complete_integral(k1) / (complete_integral(k) * complete_integral(k1c));
}

/// Where the family's own edge lies, as a multiple of the prototype's pass-band edge.
double edge_factor(const FilterRequirement& r, int order, double pass, double discrimination) {
  if (r.family == FilterFamily::chebyshev2) return std::cosh(std::acosh(discrimination) / order);
  if (r.family != FilterFamily::butterworth) return 1.0;
  const double widen = r.two_pass ? std::pow(std::sqrt(2.0) - 1.0, -1.0 / (2.0 * order)) : 1.0;
  return std::pow(pass, -1.0 / (2.0 * order)) / widen;
}

}  // namespace

FilterSpec smallest_filter(const FilterRequirement& r) {
  check(r);
  const auto warp = [&](double f) { return std::tan(pi * f / r.rate); };
  const auto hertz = [&](double w) { return std::atan(w) * r.rate / pi; };
  const Warped w{warp(r.pass_low), warp(r.pass_high), warp(r.stop_low), warp(r.stop_high)};
  const double passes = r.two_pass ? 2.0 : 1.0;
  const double pass = excess_power(r.pass_db / passes);
  const double discrimination = std::sqrt(excess_power(r.stop_db / passes) / pass);
  const double order = std::ceil(real_order(r.family, discrimination, selectivity(r.kind, w)) - 1e-9);
  if (!(order <= 16))
    throw FilterDesignError("order", order, "1 .. 16: widen the transition or lower stop_db");
  FilterSpec s;
  s.kind = r.kind;
  s.family = r.family;
  s.order = std::max(1, static_cast<int>(order));
  s.rate = r.rate;
  s.two_pass = r.two_pass;
  s.ripple_db = r.pass_db;
  s.stop_db = r.stop_db;
  const double factor = edge_factor(r, s.order, pass, discrimination);
  if (r.kind == FilterKind::low) s.high_hertz = hertz(w.p1 * factor);
  if (r.kind == FilterKind::high) s.low_hertz = hertz(w.p1 / factor);
  if (has_two_edges(r.kind)) {
    const double half = (w.p2 - w.p1) / 2 * (r.kind == FilterKind::band ? factor : 1 / factor);
    const double high = half + std::sqrt(half * half + w.p1 * w.p2);
    s.high_hertz = hertz(high);
    s.low_hertz = hertz(w.p1 * w.p2 / high);
  }
  return s;
}

}  // namespace powbench::dsp
