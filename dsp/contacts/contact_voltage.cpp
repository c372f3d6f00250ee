#include "dsp/contacts/contact_voltage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dsp/contacts/contact_train.h"
#include "dsp/filter/force.h"
#include "dsp/signal/signal.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double least_open_volts = 0.5;   ///< below this the pole carries no sense voltage
constexpr double check_tolerance = 60e-6;  ///< s: force and voltage see one event through different chains

struct Crossing {
  Measured at;
  bool closing = false;
};

Measured crossing_time(const Signal& s, std::size_t i, double level, double noise) {
  const double rise = s.value[i] - s.value[i - 1];
  const double share = std::clamp((level - s.value[i - 1]) / rise, 0.0, 1.0);
  // The step may sit anywhere between the two samples; noise moves the crossing by noise / slope.
  const double u = std::hypot(s.dt / std::sqrt(12.0), noise / std::abs(rise) * s.dt);
  return {s.time(i - 1) + share * s.dt, u};
}

std::vector<Crossing> crossings(const Signal& s, double level, double noise, double t_end) {
  std::vector<Crossing> out;
  const std::size_t last = s.index_at(t_end);
  const double guard = std::min(4 * noise, 0.25 * level);  // hysteresis
  bool closed = !s.empty() && s.value[0] < level;
  for (std::size_t i = 1; i < last; ++i) {
    if (s.masked[i] & mask_gap) continue;
    const bool now = closed ? s.value[i] < level + guard : s.value[i] < level - guard;
    if (now == closed) continue;
    std::size_t k = i;
    while (k > 1 && (s.value[k - 1] < level) == now) --k;
    out.push_back({crossing_time(s, k, level, noise), now});
    closed = now;
  }
  return out;
}

/// Openings of the train as [release, next touch], with the allowance for their uncertainty.
struct Span {
  double from, to;
};

std::vector<Span> open_spans(const ContactTrain& t, double t_end) {
  std::vector<Span> out;
  double from = -1e300;
  for (const Contact& c : t.contacts) {
    const double touch = c.touch.known() ? c.touch.value : -1e300;
    if (touch > from) out.push_back({from, touch});
    from = c.release.known() ? c.release.value : 1e300;
  }
  if (from < t_end) out.push_back({from, t_end});
  return out;
}

std::vector<Span> closed_spans(const ContactTrain& t) {
  std::vector<Span> out;
  for (const Contact& c : t.contacts)
    out.push_back({c.touch.known() ? c.touch.value : -1e300, c.release.known() ? c.release.value : 1e300});
  return out;
}

bool overlaps(const std::vector<Span>& spans, double from, double to) {
  return std::any_of(spans.begin(), spans.end(), [&](const Span& s) { return s.from < to && s.to > from; });
}

double allowance(const ContactTrain& a, const ContactTrain& b) {
  double u = 0;
  for (const ContactTrain* t : {&a, &b})
    for (const Contact& c : t->contacts)
      for (const Measured& m : {c.touch, c.release})
        if (std::isfinite(m.u)) u = std::max(u, std::min(m.u, 20e-6));
  return check_tolerance + 3 * u;
}

/// The sense voltage with the sign it should have: turned round where the open pole shows it negative.
bool turn_upright(Signal& s) {
  const auto quiet = std::span(s.value).first(s.index_at(0.0));
  const bool inverted = !quiet.empty() && median(quiet) < -least_open_volts;
  if (inverted)
    for (double& v : s.value) v = -v;
  return inverted;
}

/// V across the open pole: before switch-on, or, of a pole closed from the start, the largest; NaN: no sense voltage.
double open_voltage(const Signal& s) {
  if (s.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const auto quiet = std::span(s.value).first(s.index_at(0.0));
  double open = quiet.empty() ? 0.0 : median(quiet);
  if (open < least_open_volts) open = *std::max_element(s.value.begin(), s.value.end());
  return open < least_open_volts ? std::numeric_limits<double>::quiet_NaN() : open;
}

}  // namespace

double contact_level(const Record& record, const ExtractOptions& o) {
  Signal s = to_signal(record, Channel::contact_a);
  turn_upright(s);
  return o.open_share * open_voltage(s);
}

ContactTrain contact_voltage_train(const Record& record, const ExtractOptions& o) {
  ContactTrain t;
  Signal s = to_signal(record, Channel::contact_a);
  if (turn_upright(s)) t.flags |= flag_polarity;
  const double level = o.open_share * open_voltage(s);
  if (!std::isfinite(level)) return t;
  t.present = true;
  t.noise = robust_sigma(std::span(s.value).first(s.index_at(0.0)));
  t.resolution = std::max(o.min_open_voltage, s.dt);
  const double t_end = closing_end(record, s);
  if (s.value[0] < level) t.contacts.push_back({});  // closed before the record began
  for (const Crossing& c : crossings(s, level, t.noise, t_end)) {
    if (!c.closing) {
      t.contacts.back().release = c.at;
    } else if (!t.contacts.empty() && c.at.value - t.contacts.back().release.value < o.min_open_voltage) {
      t.contacts.back().release = {};
    } else {
      t.contacts.push_back({});
      t.contacts.back().touch = c.at;
    }
  }
  for (Contact& c : t.contacts) {
    const double to = c.release.known() ? c.release.value : t_end;
    const double from = c.touch.known() ? c.touch.value : s.t0;
    if (s.mask_within(from - s.dt, std::min(to, from) + s.dt) & mask_gap ||
        (c.release.known() && s.mask_within(to - s.dt, to + s.dt) & mask_gap))
      c.flags |= flag_gap;
    t.flags |= c.flags;
  }
  summarise(t, o.merge_openings);
  return t;
}

bool cross_check(ContactTrain& voltage, ContactTrain& a, ContactTrain& b, double t_end) {
  if (!voltage.present || (!a.present && !b.present)) return false;
  const double margin = std::max(allowance(a, b), 2 * voltage.resolution);
  bool contradiction = false;
  // 1. Pole closed: no film may be open, and however short it is, each film has a contact there.
  for (const Contact& c : voltage.contacts) {
    const double start = c.touch.known() ? c.touch.value : -1e300,
                 stop = c.release.known() ? c.release.value : t_end;
    const double from = start + margin, to = stop - margin;
    for (ContactTrain* film : {&a, &b}) {
      if (!film->present) continue;
      const bool nothing = !overlaps(closed_spans(*film), start - margin, stop + margin);
      if (!nothing && (!(to > from) || !overlaps(open_spans(*film, t_end), from, to))) continue;
      film->flags |= flag_contradiction;
      contradiction = true;
    }
  }
  // 2. Pole open: at least one film must be open. Needs both films.
  if (a.present && b.present) {
    auto open = open_spans(a, t_end);
    const auto more = open_spans(b, t_end);
    open.insert(open.end(), more.begin(), more.end());
    for (const Span& gap : open_spans(voltage, t_end)) {
      if (gap.to - gap.from < 2 * margin || overlaps(open, gap.from + margin, gap.to - margin)) continue;
      contradiction = true;
      a.flags |= flag_contradiction;
      b.flags |= flag_contradiction;
    }
  }
  if (contradiction) voltage.flags |= flag_contradiction;
  return contradiction;
}

}  // namespace powbench::dsp
