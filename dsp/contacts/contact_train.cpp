#include "dsp/contacts/contact_train.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dsp/contacts/contact_fit.h"
#include "dsp/contacts/crest.h"
#include "dsp/contacts/detect_round.h"
#include "dsp/contacts/landing.h"
#include "dsp/contacts/pulse_margin.h"
#include "dsp/contacts/refine.h"
#include "dsp/contacts/separate.h"
#include "dsp/contacts/shows.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

Neighbours neighbours(const std::vector<Interval>& c, std::size_t i) {
  Neighbours nb;
  if (i > 0) nb.previous_release = c[i - 1].release;
  if (i + 1 < c.size()) nb.next_touch = c[i + 1].touch;
  return nb;
}

/// A fit that ran into its neighbour or inside out gives way to the coarse crossings, flagged.
void keep_order(Round& r) {
  double previous = -1e300;
  for (std::size_t i = 0; i < r.fits.size(); ++i) {
    Contact& c = r.fits[i].contact;
    const Interval& coarse = r.intervals[i];
    const double next = i + 1 < r.intervals.size() ? r.intervals[i + 1].touch : 1e300;
    const bool backwards = !coarse.open_ended() && !(c.release.value > c.touch.value);
    if (backwards || c.touch.value < previous || (!coarse.open_ended() && c.release.value > next)) {
      const double u = r.levels.width;
      c.touch = {std::max(coarse.touch, previous), u};
      if (!coarse.open_ended()) c.release = {coarse.release, u};
      c.flags |= flag_poor_fit;
      r.fits[i].shape = nullptr;
    }
    if (!coarse.open_ended()) previous = c.release.value;
  }
}

Round find_contacts(const Signal& force, double noise, double settled, double t_end,
                    const ExtractOptions& o) {
  Round r = detect_round(force, noise, settled, t_end, o, true);
  const FitInput in{force, r.smooth, r.noise, r.levels, o};
  r.fits.clear();
  for (std::size_t i = 0; i < r.intervals.size(); ++i)
    r.fits.push_back(fit_contact(in, r.intervals[i], neighbours(r.intervals, i)));
  keep_order(r);
  return r;
}

/// Largest and smallest value of a signal between two times.
std::pair<double, double> range_of(const Signal& s, double from, double to) {
  const std::size_t a = std::min(s.index_at(from), s.size() - 1),
                    b = std::clamp(s.index_at(to), a + 1, s.size());
  const auto [low, high] =
      std::minmax_element(s.value.begin() + std::ptrdiff_t(a), s.value.begin() + std::ptrdiff_t(b));
  return {*low, *high};
}

/// Vibration swings to both sides, a contact only presses. So a stripped ring has taken a contact where an interval
/// of the force as it came (`unaided`) hardly swings below zero within its own length on either side and is none of
/// the contacts that are `left`, or an opening where the force as it came rests at zero between two of them and what
/// is left stays closed.
bool takes_a_contact(const Signal& force, const std::vector<Interval>& unaided,
                     const std::vector<Interval>& left) {
  constexpr double swing = 0.3, rest = 0.15;  // of the peak
  constexpr double longest = 1e-3;            // s
  const auto closed_within = [&](double from, double to) {
    return std::any_of(left.begin(), left.end(),
                       [&](const Interval& c) { return c.touch < to && c.release > from; });
  };
  const auto closed_throughout = [&](double from, double to) {
    return std::any_of(left.begin(), left.end(),
                       [&](const Interval& c) { return c.touch < from && c.release > to; });
  };
  double before = 0;
  for (std::size_t i = 0; i < unaided.size(); ++i) {
    const Interval& c = unaided[i];
    const double end = c.open_ended() ? c.touch + longest : c.release,
                 reach = std::min(end - c.touch, longest);
    const double peak = range_of(force, c.touch, end).second;
    if (!c.open_ended() && !closed_within(c.touch, c.release) &&
        range_of(force, c.touch - reach, c.release + reach).first > -swing * peak)
      return true;
    if (i > 0) {
      const auto [low, high] = range_of(force, unaided[i - 1].release, c.touch);
      const double most = rest * std::min(before, peak);
      if (-low < most && high < most && closed_throughout(unaided[i - 1].release, c.touch)) return true;
    }
    before = peak;
  }
  return false;
}

/// Standard deviation of what is left in the open time after the ring started.
double open_noise(const Signal& stripped, const Round& r, const Ring& ring, double t_end, double floor) {
  std::vector<double> left;
  std::size_t k = 0;
  for (std::size_t i = stripped.index_at(ring.onset); i < stripped.size() && stripped.time(i) < t_end; ++i) {
    const double t = stripped.time(i);
    while (k < r.intervals.size() && r.intervals[k].release + 30e-6 < t) ++k;
    const bool closed = k < r.intervals.size() && t > r.intervals[k].touch - 30e-6;
    if (!closed && !stripped.masked[i]) left.push_back(stripped.value[i]);
    if (closed && r.intervals[k].open_ended()) break;
  }
  return left.size() < 20 ? floor : std::max(floor, std::min(robust_sigma(left), 5 * floor));
}

/// Contacts of a joint fit that leaves nothing to ask; their uncertainties hold the ring's share.
void use_joint_fit(Round& r, const JointModel& m, const Force& f, const Signal& stripped,
                   const ExtractOptions& o) {
  r.intervals.clear();
  r.fits.clear();
  const auto grow = [](double reduced) { return std::sqrt(std::max(reduced, 1.0)); };
  for (std::size_t k = 0; k < m.pulses.size(); ++k) {
    const JointPulse& p = m.pulses[k];
    ContactFit fit;
    fit.contact = contact_from(p.shape, {p.shape.touch, p.u_touch}, {p.shape.release, p.u_release},
                               {p.shape.peak, p.u_peak}, stripped, f.noise, grow(p.reduced_chi2));
    if (p.u_exponent > open_exponent) {
      const double before = k > 0 ? m.pulses[k - 1].shape.release : -1e300;
      const double after = k + 1 < m.pulses.size() ? m.pulses[k + 1].shape.touch : m.rise->touch;
      const PulseMargin margin =
          over_exponents(stripped, f.noise, p.shape, std::max(before, p.shape.touch - o.fit_margin),
                         std::min(after, p.shape.release + o.fit_margin), o);
      if (margin.known) use_margin(fit.contact, margin, grow(p.reduced_chi2));
    }
    r.intervals.push_back({p.shape.touch, p.shape.release});
    r.fits.push_back(std::move(fit));
  }
  ContactFit last;
  const double t = m.rise->touch, dt = stripped.dt;
  last.contact.touch = {
      t, std::hypot(m.rise->u_touch * grow(m.rise->reduced_chi2), shape_uncertainty(dt, m.rise->rise))};
  last.contact.peak = {r.smooth_peak(t, t + 300e-6), f.noise};
  last.contact.flags = flags_of_mask(stripped, t, t + 300e-6);
  r.intervals.push_back({t, std::numeric_limits<double>::infinity()});
  r.fits.push_back(std::move(last));
}

/// A shape that does not fit says nothing beyond the film: where its peak stands above all that the film shows while
/// the contact is closed, the film's largest value is the peak, and as uncertain as the two are apart. A clipped film
/// shows too little.
void hold_peak(Contact& c, const Signal& film) {
  constexpr double first_rise = 300e-6;  // s, of a contact that stays closed
  if (!(c.flags & flag_poor_fit) || (c.flags & flag_clipped) || !c.peak.known()) return;
  const double end = c.release.known() ? c.release.value : c.touch.value + first_rise;
  double seen = 0;
  for (std::size_t i = film.index_at(c.touch.value); i < film.size() && film.time(i) <= end; ++i)
    if (!film.masked[i]) seen = std::max(seen, film.value[i]);
  if (!(c.peak.value > seen) || !(seen > 0)) return;
  c.peak.u = std::hypot(c.peak.u, c.peak.value - seen);
  c.peak.value = seen;
}

/// What the film shows of a vibration that is not all explained; nothing where it shows none, nor where the core was
/// seen to land: there the ring is fitted from the landing on, and what it leaves is doubted by itself. `vibrates`:
/// the film swings below zero.
std::optional<VibratingFilm> vibrating_film(const Force& f, const std::vector<Interval>& contacts,
                                            double t_end, const Measured& core_seat, bool vibrates,
                                            const ExtractOptions& o) {
  if (contacts.empty() || core_seat.known()) return std::nullopt;
  VibratingFilm film{f.signal, calm_force(f.signal, f.noise, o)};
  if (contacts.back().open_ended()) {
    film.last = contacts.back().touch;
    film.at_rest = vibration_at_rest(film.calm, f.signal, film.last, t_end);
  }
  return vibrates || film.at_rest > 0 ? std::optional(std::move(film)) : std::nullopt;
}

/// Where the core was not seen to land: the contact that stays closed shows a vibration.
bool vibrates_at_rest(const Force& f, const std::vector<Interval>& contacts, double t_end,
                      const Measured& core_seat, const ExtractOptions& o) {
  if (core_seat.known() || contacts.empty() || !contacts.back().open_ended()) return false;
  return vibration_at_rest(calm_force(f.signal, f.noise, o), f.signal, contacts.back().touch, t_end) > 0;
}

std::vector<Grazing> fill_train(ContactTrain& train, const Round& r, const Force& f, const ForceAnalysis& a,
                                double t_end, const VibratingFilm* vibrating, const ExtractOptions& o) {
  for (const ContactFit& fit : r.fits) train.contacts.push_back(fit.contact);
  drop_swings(train.contacts, a.stripped, f.noise, o);
  for (Contact& c : train.contacts)
    hold_peak(c, f.signal);  // before an edge that follows a law takes the flag away
  const double left = a.ring.empty() ? f.noise : open_noise(a.stripped, r, a.ring, t_end, f.noise);
  auto grazing = refine_contacts(
      train.contacts, {a.stripped, std::max(left, r.noise), f.noise, f.delay, 2 * f.wander, vibrating}, o);
  for (Contact& c : train.contacts) {
    hold_peak(c, f.signal);
    c.peak.u = std::hypot(c.peak.u, f.wander);  // the zero below a peak is that of the open time beside it
    train.flags |= c.flags & (flag_clipped | flag_gap);
  }
  train.noise = f.noise;
  train.resolution = r.levels.resolution;
  const Signal& s = f.signal;
  const std::size_t i1 = s.index_at(std::max(t_end - o.settled_window, 0.0)), i2 = s.index_at(t_end);
  if (!r.intervals.empty() && r.intervals.back().open_ended() && i2 > i1) {
    double sum = 0, squares = 0;
    const double n = static_cast<double>(i2 - i1);
    for (std::size_t i = i1; i < i2; ++i) sum += s.value[i], squares += s.value[i] * s.value[i];
    // The zero level's own error, accumulated by the droop inverse, is small beside the pulsation's sampling.
    train.settled_force = {sum / n,
                           std::sqrt(std::max(squares / n - sum * sum / n / n, f.noise * f.noise) / n)};
  }
  return grazing;
}

/// A last opening that may be none, or a dip that may be an opening behind the last touch: settled may be as far off
/// as they are apart.
void admit_grazing(ContactTrain& t, const std::vector<Grazing>& dips) {
  if (!t.settled.known()) return;
  constexpr double same = 1e-9;  // s
  for (const Grazing& g : dips) {
    if (std::abs(t.settled.value - g.before) > same && std::abs(t.settled.value - g.after) > same) continue;
    t.settled.u = std::hypot(t.settled.u, g.share() * (g.after - g.before));
    t.bounce_time.u = std::hypot(t.bounce_time.u, g.share() * (g.after - g.before));
  }
}

/// An opening whose zero has wandered up to the release level would not be seen: the levels rise above what wanders,
/// and whether a dip between them is an opening is then for `look_at_dip` to say.
ExtractOptions above_wander(const Force& f, ExtractOptions o) {
  constexpr double sigmas = 6, most = 0.15, between = 1.5;
  if (!(f.wander > 0 && f.settled > 0)) return o;
  o.release_share = std::max(o.release_share, std::min(sigmas * f.wander / f.settled, most));
  o.touch_share = std::max(o.touch_share, between * o.release_share);
  return o;
}

}  // namespace

void summarise(ContactTrain& t, double merge) {
  if (merge > 0) {
    std::vector<Contact> kept;
    for (const Contact& c : t.contacts) {
      if (kept.empty() || c.touch.value - kept.back().release.value > merge) {
        kept.push_back(c);
        continue;
      }
      Contact& last = kept.back();
      last.release = c.release;
      if (c.peak.value > last.peak.value) last.peak = c.peak;
      last.impulse = {last.impulse.value + c.impulse.value, std::hypot(last.impulse.u, c.impulse.u)};
      last.flags |= c.flags;
    }
    t.contacts = std::move(kept);
  }
  t.settled = t.bounce_time = {};
  t.bounce_count = t.contacts.empty() ? 0 : static_cast<int>(t.contacts.size()) - 1;
  if (t.contacts.empty() || t.contacts.back().release.known()) return;  // never stays closed
  t.settled = t.contacts.back().touch;
  const Measured first = t.contacts.front().touch;
  t.bounce_time = t.contacts.size() == 1
                      ? Measured{0.0, 0.0}
                      : Measured{t.settled.value - first.value, std::hypot(t.settled.u, first.u)};
}

ForceAnalysis analyse_force(const Force& f, double t_end, const Measured& core_seat,
                            const ExtractOptions& given) {
  const ExtractOptions o = above_wander(f, given);
  ForceAnalysis out;
  out.train.present = f.present;
  out.train.flags = f.flags;
  out.stripped = f.signal;
  if (!f.present) return out;

  Round round = detect_round(f.signal, f.noise, f.settled, t_end, o, false);
  const std::vector<Interval> unaided = round.intervals;
  Separated best, bare;
  bool bare_enough = false;
  const bool vibrates = !round.intervals.empty() && swings_below_zero(f, round.intervals, t_end, o);
  if (o.ring_modes > 0 && (vibrates || vibrates_at_rest(f, round.intervals, t_end, core_seat, o))) {
    if (!vibrates) bare = without_ring(f, round, t_end, o);
    best =
        vibrates ? separate_ring(f, round, core_seat, t_end, o) : separate_at_rest(f, round, bare, t_end, o);
    // A ring has to earn its parameters: a settled force that bends a little is no vibration. Where the core was seen
    // to land vibration is expected, and only its absence asks.
    if (!core_seat.known() || !best.found) {
      if (vibrates) bare = without_ring(f, round, t_end, o);
      bare_enough = convincing(bare) && !(best.found && best.model.cost() < bare.model.cost());
    }
    if (!bare_enough && worth_stripping(best, f.noise)) {
      out.ring = best.model.ring;
      take_out(best.model, out.stripped);
    }
  }
  if (bare_enough) {
    use_joint_fit(round, bare.model, f, out.stripped, o);
  } else if (!out.ring.empty() && convincing(best)) {
    round = std::move(best.round);
    use_joint_fit(round, best.model, f, out.stripped, o);
  } else {
    const double noise =
        out.ring.empty() ? f.noise : open_noise(out.stripped, best.round, out.ring, t_end, f.noise);
    round = find_contacts(out.stripped, noise, f.settled, t_end, o);
  }
  // a ring that explains all open time to its noise has taken no contact: no few modes look like one pulse
  if (!out.ring.empty() && !bare_enough && !convincing(best) && !best.open_time &&
      takes_a_contact(f.signal, unaided, round.intervals)) {
    out.ring = {};
    out.stripped = f.signal;
    round = find_contacts(f.signal, f.noise, f.settled, t_end, o);
    out.train.flags |= flag_ring_overlap;
  }
  if (round.overlap) out.train.flags |= flag_ring_overlap;
  const auto vibrating = vibrating_film(f, round.intervals, t_end, core_seat, vibrates, o);
  const auto grazing = fill_train(out.train, round, f, out, t_end, vibrating ? &*vibrating : nullptr, o);
  if (!out.ring.empty() && !bare_enough && !convincing(best))
    doubt_stripping(out.train.contacts, f.signal, {out.stripped, round.noise, f.noise, f.delay}, out.ring, o);
  const double blow = out.ring.empty() ? 0 : out.ring.amplitude_at(out.ring.onset);
  const auto hidden = [&](double t, int side) {
    return hidden_by_vibration({out.stripped, round.noise, f.noise, f.delay}, t, side, blow, o);
  };
  if (doubt_landing(out.train.contacts, unaided, core_seat, blow, hidden))
    out.train.flags |= flag_ring_overlap;
  const Verdict verdict = verdict_of(f, out.train.contacts, t_end, o);
  out.train.shows = verdict.shows;
  out.train.reason = verdict.reason;
  if (verdict.shows == Shows::vibration) out.train.contacts.clear();
  summarise(out.train, o.merge_openings);
  admit_grazing(out.train, grazing);
  return out;
}

}  // namespace powbench::dsp
