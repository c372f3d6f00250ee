#include "dsp/filter/event_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "dsp/filter/bands.h"
#include "dsp/filter/cascade.h"
#include "dsp/filter/sos.h"

namespace powbench::dsp {

namespace {

constexpr int filter_order = 2;
constexpr double noticed = 0.03;  ///< of a step: what of it counts as seen

std::string kilohertz(double hertz) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", hertz * 1e-3);
  return text;
}

/// The filtered step that stands between samples n / 2 - 1 and n / 2.
std::vector<double> step_response(const EventFilter& f, double rate) {
  const Cascade cascade(spec_of(f, rate));
  std::vector<double> x(4 * cascade.memory() + 64);
  std::fill(x.begin() + std::ptrdiff_t(x.size() / 2), x.end(), 1.0);
  if (f.phase == FilterPhase::zero)
    cascade.zero_phase(x);
  else
    cascade.forward(x);
  return x;
}

/// Position in samples where `x` first rises through `level`.
double rises_through(const std::vector<double>& x, double level) {
  for (std::size_t i = 1; i < x.size(); ++i)
    if (x[i] >= level && x[i - 1] < level)
      return static_cast<double>(i - 1) + (level - x[i - 1]) / (x[i] - x[i - 1]);
  return 0;
}

/// Marks of clipped and lost samples reach `samples` further.
void spread_masks(std::vector<std::uint8_t>& masked, std::size_t samples) {
  constexpr std::uint8_t bad = mask_clipped | mask_gap;
  const std::vector<std::uint8_t> was = masked;
  std::size_t last = 0;
  std::uint8_t bits = 0;
  const auto carry = [&](std::size_t i, std::size_t step) {
    if (was[i] & bad) last = step, bits = was[i] & bad;
    if (bits && step - last <= samples) masked[i] |= bits;
  };
  for (std::size_t i = 0; i < was.size(); ++i) carry(i, i);
  bits = 0;
  for (std::size_t i = was.size(); i-- > 0;) carry(i, was.size() - i);
}

void widen(Measured& m, double u) {
  if (m.known()) m.u = std::hypot(m.u, u);
}

}  // namespace

std::string name_of(const EventFilter& f) {
  const char* const phase = f.phase == FilterPhase::zero ? " zero phase" : " causal";
  switch (f.kind) {
    case EventFilter::Kind::none:
      return "none";
    case EventFilter::Kind::plain:
      return f.high_hertz > 0 ? "plain low-pass " + kilohertz(f.high_hertz) + " kHz" + phase
                              : "plain low-pass";
    case EventFilter::Kind::low:
      return "low-pass " + kilohertz(f.high_hertz) + " kHz" + phase;
    case EventFilter::Kind::stop:
      return "band-stop " + kilohertz(f.low_hertz) + ".." + kilohertz(f.high_hertz) + " kHz" + phase;
  }
  return "";
}

FilterSpec spec_of(const EventFilter& f, double rate) {
  const bool two_pass = f.phase == FilterPhase::zero;
  if (f.kind == EventFilter::Kind::plain) {
    BandReport contact;
    contact.contact = {0, f.high_hertz};
    return plain_filter(contact, rate);
  }
  return {f.kind == EventFilter::Kind::stop ? FilterKind::stop : FilterKind::low,
          filter_order,
          f.low_hertz,
          f.high_hertz,
          rate,
          two_pass};
}

FilterEffect effect_of(const EventFilter& f, double rate) {
  const std::vector<double> x = step_response(f, rate);
  const double step = static_cast<double>(x.size() / 2) - 0.5, half = rises_through(x, 0.5);
  const auto seen = [&](double from, double v) { return std::abs(v - from) > noticed; };
  const auto first = std::find_if(x.begin(), x.end(), [&](double v) { return seen(0, v); });
  const auto last = std::find_if(x.rbegin(), x.rend(), [&](double v) { return seen(1, v); });
  FilterEffect e;
  e.delay = f.phase == FilterPhase::zero ? 0.0 : (half - step) / rate;
  e.before = std::max(0.5, half - static_cast<double>(first - x.begin())) / rate;
  e.after = std::max(0.5, static_cast<double>(x.rend() - last) - half) / rate;
  e.rise = (rises_through(x, 0.9) - rises_through(x, 0.1)) / rate;
  double largest = 0;
  for (auto i = static_cast<std::size_t>(half + 1 + e.rise * rate); i < x.size(); ++i)
    largest = std::max(largest, std::abs(x[i] - 1));
  e.swing =
      largest * (f.kind == EventFilter::Kind::stop ? 2 / (f.low_hertz + f.high_hertz) : 1 / f.high_hertz);
  return e;
}

double u_touch(const FilterEffect& e) {
  return std::hypot(e.before, e.swing) / std::sqrt(3.0);
}
double u_release(const FilterEffect& e) {
  return std::hypot(e.after, e.swing) / std::sqrt(3.0);
}

double gain_of(const EventFilter& f, double hertz, double rate) {
  const FilterSpec spec = spec_of(f, rate);
  if (hertz >= rate / 2) return f.kind == EventFilter::Kind::stop ? 1.0 : 0.0;
  const double g = std::abs(response(to_sections(spec), hertz, rate));
  return spec.two_pass ? g * g : g;
}

void apply_filter(Signal& s, const EventFilter& f) {
  if (s.empty()) return;
  const FilterSpec spec = spec_of(f, s.rate());
  const auto sections = to_sections(spec);
  const FilterEffect effect = effect_of(f, s.rate());
  if (spec.two_pass) {
    s = filter_zero_phase(sections, s).signal;
  } else {
    const std::size_t memory = filter_memory(sections, 1e-3, s.size() + 1);
    if (memory > s.size()) throw FilterMemoryError(s.size(), memory);
    bridge_gaps(s);
    filter_forward(sections, s.value);
    s.t0 -= effect.delay;
  }
  spread_masks(s.masked, static_cast<std::size_t>(0.5 * effect.rise / s.dt));
}

void admit_filter(ContactTrain& t, const FilterEffect& e) {
  const double before = u_touch(e), after = u_release(e);
  for (Contact& c : t.contacts) {
    widen(c.touch, before);
    widen(c.release, after);
    if (!c.release.known() || !c.peak.known()) continue;
    // a half sine of length T behind a rise r keeps about 1 - r^2 / T^2 of its height
    const double r = e.rise / std::max(c.release.value - c.touch.value, e.rise);
    widen(c.peak, c.peak.value * r * r);
  }
  if (t.contacts.size() > 1) widen(t.bounce_time, std::sqrt(2.0) * before);
  widen(t.settled, before);
  t.resolution = std::max(t.resolution, e.rise);
}

}  // namespace powbench::dsp
