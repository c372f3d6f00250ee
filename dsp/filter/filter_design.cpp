#include "dsp/filter/filter_design.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "dsp/filter/prototype.h"

namespace powbench::dsp {

namespace {

using Complex = std::complex<double>;

std::string number(double v) {
  return std::to_string(v);
}

bool uses_low(FilterKind k) {
  return k != FilterKind::low;
}
bool uses_high(FilterKind k) {
  return k != FilterKind::high;
}

void require_edge(const char* key, double hertz, double rate) {
  if (!(hertz > 0) || !(hertz < rate / 2))
    throw FilterDesignError(key, hertz, "0 .. " + number(rate / 2) + " Hz, exclusive");
}

void check_decibels(const FilterSpec& s) {
  const bool ripple = s.family == FilterFamily::chebyshev1 || s.family == FilterFamily::elliptic;
  const bool stop = s.family == FilterFamily::chebyshev2 || s.family == FilterFamily::elliptic;
  if (ripple && (!(s.ripple_db >= 1e-6) || !(s.ripple_db <= 20)))
    throw FilterDesignError("ripple_db", s.ripple_db, "1e-6 .. 20 dB");
  if (stop && (!(s.stop_db >= 1) || !(s.stop_db <= 240)))
    throw FilterDesignError("stop_db", s.stop_db, "1 .. 240 dB");
  if (ripple && stop && !(s.stop_db >= 1.5 * s.ripple_db))
    throw FilterDesignError("stop_db", s.stop_db, "at least 1.5 ripple_db = " + number(1.5 * s.ripple_db));
}

void check(const FilterSpec& s) {
  if (s.order < 1 || s.order > 16) throw FilterDesignError("order", s.order, "1 .. 16");
  if (!(s.rate > 0) || !std::isfinite(s.rate)) throw FilterDesignError("rate", s.rate, "> 0 Hz");
  if (uses_low(s.kind)) require_edge("low_hertz", s.low_hertz, s.rate);
  if (uses_high(s.kind)) require_edge("high_hertz", s.high_hertz, s.rate);
  if (uses_low(s.kind) && uses_high(s.kind) && !(s.low_hertz < s.high_hertz))
    throw FilterDesignError("low_hertz", s.low_hertz, "below high_hertz = " + number(s.high_hertz));
  check_decibels(s);
}

/// Analog filter in units of 2 rate: bilinear z = (1 + s) / (1 - s), so frequencies are tan(pi f / rate).
struct Analog {
  std::vector<Complex> poles;
  std::vector<double> zero_pairs;  ///< +-i w
  int zeros_at_0 = 0;
  int zeros_at_infinity = 0;
  double gain = 1;
  double dc_gain = 1;
  double centre = 0;  ///< cut-off, or geometric centre of the band
};

struct Edges {
  double centre = 0, width = 0;
};

Edges analog_edges(const FilterSpec& s) {
  const auto warp = [&](double f) { return std::tan(pi * f / s.rate); };
  const bool moves = s.two_pass && s.family == FilterFamily::butterworth;
  const double widen = moves ? std::pow(std::sqrt(2.0) - 1.0, -1.0 / (2.0 * s.order)) : 1.0;
  if (s.kind == FilterKind::low) return {warp(s.high_hertz) * widen, 0};
  if (s.kind == FilterKind::high) return {warp(s.low_hertz) / widen, 0};
  const double lo = warp(s.low_hertz), hi = warp(s.high_hertz);
  // tan(b) - tan(a) = sin(b - a) / (cos a cos b): no cancellation for narrow bands
  const double a = pi * s.low_hertz / s.rate, b = pi * s.high_hertz / s.rate;
  const double width = std::sin(pi * (s.high_hertz - s.low_hertz) / s.rate) / (std::cos(a) * std::cos(b));
  return {std::sqrt(lo * hi), s.kind == FilterKind::band ? width * widen : width / widen};
}

void split_pole(Analog& out, Complex half) {
  const Complex root = std::sqrt((half - out.centre) * (half + out.centre));
  // the larger root by addition, the other from the product of the two
  const Complex far = std::real(half * std::conj(root)) >= 0 ? half + root : half - root;
  out.poles.push_back(far);
  out.poles.push_back(out.centre * out.centre / far);
}

void split_zero(Analog& out, double half) {
  const double far = half + std::hypot(half, out.centre);
  out.zero_pairs.push_back(far);
  out.zero_pairs.push_back(out.centre * out.centre / far);
}

Analog analog(const FilterSpec& s) {
  check(s);
  const double passes = s.two_pass ? 2.0 : 1.0;
  const Prototype p = prototype(s.family, s.order, s.ripple_db / passes, s.stop_db / passes);
  const Edges e = analog_edges(s);
  Analog out;
  out.centre = e.centre;
  out.dc_gain = p.dc_gain;
  const int excess = s.order - 2 * static_cast<int>(p.zeros.size());
  out.gain = s.kind == FilterKind::low    ? p.gain * std::pow(e.centre, excess)
             : s.kind == FilterKind::band ? p.gain * std::pow(e.width, excess)
                                          : p.dc_gain;
  for (const Complex pole : p.poles) {
    if (s.kind == FilterKind::low) out.poles.push_back(pole * e.centre);
    if (s.kind == FilterKind::high) out.poles.push_back(e.centre / pole);
    if (s.kind == FilterKind::band) split_pole(out, pole * (e.width / 2));
    if (s.kind == FilterKind::stop) split_pole(out, (e.width / 2) / pole);
  }
  for (const double w : p.zeros) {
    if (s.kind == FilterKind::low) out.zero_pairs.push_back(w * e.centre);
    if (s.kind == FilterKind::high) out.zero_pairs.push_back(e.centre / w);
    if (s.kind == FilterKind::band) split_zero(out, w * (e.width / 2));
    if (s.kind == FilterKind::stop) split_zero(out, (e.width / 2) / w);
  }
  if (s.kind == FilterKind::stop) out.zero_pairs.insert(out.zero_pairs.end(), excess, e.centre);
  if (s.kind == FilterKind::high || s.kind == FilterKind::band) out.zeros_at_0 = excess;
  if (s.kind == FilterKind::low || s.kind == FilterKind::band) out.zeros_at_infinity = excess;
  return out;
}

/// Denominator of one section. Poles are those of the s-plane; a single real pole has its partner at z = 0.
struct PolePair {
  Complex s;  ///< upper one of a conjugate pair, or the slower of two real ones
  double d1 = 0, d0 = 0, radius = 0;
  bool single = false;
};

/// delta of an s-plane point: z - 1 = 2 s / (1 - s).
Complex delta(Complex s) {
  return 2.0 * s / (1.0 - s);
}

PolePair real_poles(double p1, double p2) {
  const double x1 = 2 * p1 / (1 - p1), x2 = 2 * p2 / (1 - p2);
  return {p1, -(x1 + x2), x1 * x2, std::max(std::abs(1 + x1), std::abs(1 + x2)), false};
}

/// Conjugates together, then real poles two by two, largest radius first; a single real pole last.
std::vector<PolePair> pole_pairs(const std::vector<Complex>& poles) {
  std::vector<PolePair> pairs;
  std::vector<double> real;
  for (const Complex p : poles) {
    if (std::abs(p.imag()) < 1e-14 * std::abs(p)) {
      real.push_back(p.real());
    } else if (p.imag() > 0) {
      const Complex x = delta(p);
      pairs.push_back({p, -2 * x.real(), std::norm(x), std::abs(1.0 + x), false});
    }
  }
  std::sort(real.begin(), real.end());
  for (std::size_t i = 0; i + 1 < real.size(); i += 2) pairs.push_back(real_poles(real[i], real[i + 1]));
  if (real.size() % 2) {
    const double x = 2 * real.back() / (1 - real.back());
    pairs.push_back({real.back(), 1 - x, -x, 0.0, true});
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const PolePair& a, const PolePair& b) { return a.radius > b.radius; });
  return pairs;
}

/// Takes the numerator for one section out of the filter's zeros.
void take_zeros(Analog& a, const PolePair& p, Section& q) {
  q.b0 = 1;
  if (!a.zero_pairs.empty() && !p.single) {
    const double w = p.s.imag() != 0 ? std::abs(p.s.imag()) : std::abs(p.s);
    const auto distance = [w](double z) { return std::abs(std::log(z / w)); };
    const auto best = std::min_element(a.zero_pairs.begin(), a.zero_pairs.end(),
                                       [&](double x, double y) { return distance(x) < distance(y); });
    q.n0 = 4 * *best * *best / (1 + *best * *best);
    q.n1 = q.n0;
    a.zero_pairs.erase(best);
    return;
  }
  q.n1 = 0, q.n0 = 0;
  if (p.single) {  // one zero, and one at z = 0 against the partner of the pole
    const bool at_0 = a.zeros_at_0 > 0;
    --(at_0 ? a.zeros_at_0 : a.zeros_at_infinity);
    q.n1 = at_0 ? 1 : 3, q.n0 = at_0 ? 0 : 2;
  } else if (a.zeros_at_0 > 0 && a.zeros_at_infinity > 0) {
    --a.zeros_at_0, --a.zeros_at_infinity;
    q.n1 = 2, q.n0 = 0;
  } else if (a.zeros_at_0 > 0) {
    a.zeros_at_0 -= 2;
  } else {
    a.zeros_at_infinity -= 2;
    q.n1 = 4, q.n0 = 4;
  }
}

/// delta on the unit circle at `angle` = 2 half: exp(i angle) - 1.
Complex circle_delta(double half) {
  return Complex(0, 2 * std::sin(half)) * std::polar(1.0, half);
}

Complex evaluate(const Section& q, Complex x) {
  return (q.n0 + x * (q.n1 + x * q.b0)) / (q.d0 + x * (q.d1 + x));
}

Complex reference_delta(const FilterSpec& s, double centre) {
  if (s.kind == FilterKind::high) return -2.0;
  return s.kind == FilterKind::band ? circle_delta(std::atan(centre)) : Complex(0.0);
}

}  // namespace

FilterDesignError::FilterDesignError(const std::string& key, double value, const std::string& allowed)
    : std::invalid_argument(key + " = " + number(value) + ": allowed " + allowed) {}

Zpk design_zpk(const FilterSpec& s) {
  const Analog a = analog(s);
  Zpk out;
  Complex h = 1.0;
  for (const Complex p : a.poles) {
    out.poles.push_back((1.0 + p) / (1.0 - p));
    h /= 1.0 - p;
  }
  for (const double w : a.zero_pairs) {
    const double d = 1 + w * w;
    out.zeros.insert(out.zeros.end(),
                     {{(1 - w) * (1 + w) / d, 2 * w / d}, {(1 - w) * (1 + w) / d, -2 * w / d}});
    h *= d;
  }
  out.zeros.insert(out.zeros.end(), static_cast<std::size_t>(a.zeros_at_0), 1.0);
  out.zeros.insert(out.zeros.end(), static_cast<std::size_t>(a.zeros_at_infinity), -1.0);
  out.gain = a.gain * h.real();
  return out;
}

std::vector<Section> to_sections(const FilterSpec& s) {
  Analog a = analog(s);
  const auto pairs = pole_pairs(a.poles);
  const Complex at = reference_delta(s, a.centre);
  const double share = std::pow(a.dc_gain, 1.0 / static_cast<double>(pairs.size()));
  std::vector<Section> out;
  for (const PolePair& p : pairs) {
    Section q;
    q.d1 = p.d1, q.d0 = p.d0;
    take_zeros(a, p, q);
    const double g = share / std::abs(evaluate(q, at));
    q.b0 *= g, q.n1 *= g, q.n0 *= g;
    out.push_back(q);
  }
  return out;
}

std::complex<double> response(const std::vector<Section>& sections, double hertz, double rate) {
  const Complex x = circle_delta(pi * hertz / rate);
  Complex h = 1.0;
  for (const Section& q : sections) h *= evaluate(q, x);
  return h;
}

}  // namespace powbench::dsp
