#include "dsp/contact_train.h"

#include <algorithm>
#include <cmath>

#include "dsp/contact_fit.h"
#include "dsp/statistics.h"

namespace powbench::dsp {

namespace {

struct Round {
  DetectionLevels levels;
  std::vector<Interval> intervals;
  std::vector<ContactFit> fits;
  double noise = 0;      ///< N, one sample, ring residue included
  bool overlap = false;  ///< vibration was left in and the levels raised above it
};

Neighbours neighbours(const std::vector<Interval>& c, std::size_t i) {
  Neighbours nb;
  if (i > 0) nb.previous_release = c[i - 1].release;
  if (i + 1 < c.size()) nb.next_touch = c[i + 1].touch;
  return nb;
}

/// Standard deviation of x where `open`, between the first touch and the last: robust, or with `bursts` the plain one, in
/// which a ring that dies quickly counts in full.
double open_sigma(std::span<const double> x, const std::vector<std::uint8_t>& open, const Signal& s,
                  const Detection& d, bool bursts = false) {
  if (d.intervals.empty()) return 0.0;
  const double end = d.intervals.back().open_ended() ? d.intervals.back().touch : d.intervals.back().release;
  std::vector<double> left;
  for (std::size_t i = s.index_at(d.intervals.front().touch); i < s.index_at(end); ++i)
    if (open[i] && !s.masked[i]) left.push_back(x[i]);
  if (left.size() < 30) return 0.0;
  if (!bursts) return robust_sigma(left);
  double squares = 0;
  for (const double v : left) squares += v * v;
  return std::sqrt(squares / static_cast<double>(left.size()));
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

/// Contacts above white noise; where the open time rings at a frequency that a wider Gaussian removes and a narrow one
/// does not, the wider one is taken (and the resolution reported with it).
Round find_contacts(const Signal& force, double noise, double settled, double t_end, const ExtractOptions& o,
                    bool final_round = false) {
  constexpr double wide = 30e-6;
  Round r;
  r.noise = noise;
  r.levels = detection_levels(noise, force.dt, settled, o);
  const double begin = force.t0 + 5 * r.levels.width;
  Detection d = detect_contacts(force, r.levels, begin, t_end, o);
  const auto open = zero_on_average(force, std::max(0.1 * settled, r.levels.release), final_round);
  const double narrow_sigma = open_sigma(d.smooth, open, force, d);
  if (r.levels.width < wide && narrow_sigma > 2.5 * r.levels.noise) {
    const double white = noise * gaussian_noise_gain(wide / force.dt);
    const auto smooth = gaussian_smooth(force.value, wide / force.dt);
    const double sigma = std::max(white, open_sigma(smooth, open, force, d));
    if (sigma < narrow_sigma / 4) {
      r.levels = levels_at_width(wide, sigma, force.dt, settled, o);
      r.noise = std::max(noise, open_sigma(force.value, open, force, d));
      d = detect_contacts(force, r.levels, begin, t_end, o);
    }
  }
  // A decaying ring is half again as large at its start as its median says.
  const double rest = final_round ? std::max(1.5 * open_sigma(d.smooth, open, force, d),
                                             open_sigma(d.smooth, open, force, d, true))
                                  : 0.0;
  if (rest > 2.5 * r.levels.noise && 4 * rest > r.levels.touch) {
    // Vibration that could not be taken out: the levels rise above it, and the train says so.
    r.levels =
        levels_at_width(r.levels.width, std::min(0.7 * rest, 0.5 * settled / o.touch_sigmas + r.levels.noise),
                        force.dt, settled, o);
    r.noise = std::max(r.noise, open_sigma(force.value, open, force, d));
    r.overlap = true;
    d = detect_contacts(force, r.levels, begin, t_end, o);
  }
  r.intervals = std::move(d.intervals);
  const FitInput in{force, d.smooth, r.noise, r.levels, o, !final_round};
  for (std::size_t i = 0; i < r.intervals.size(); ++i)
    r.fits.push_back(fit_contact(in, r.intervals[i], neighbours(r.intervals, i)));
  keep_order(r);
  return r;
}

/// Where nothing but ring, noise and the smooth settled force is left once the modelled contacts are
/// subtracted.
struct Residual {
  Signal signal;
  std::vector<std::uint8_t> usable;
  double last_touch = 0;  ///< s; end of the closing when nothing stays closed
};

/// `keep_small`: contacts that may be ring stay in the signal and stay usable (for the onset); else they are left out.
Residual residual_of(const Signal& force, const Round& r, const Ring& ring, double t_end, bool keep_small) {
  Residual out{force, std::vector<std::uint8_t>(force.size(), 1), t_end};
  for (std::size_t k = 0; k < r.fits.size(); ++k) {
    const Interval& c = r.intervals[k];
    if (c.open_ended()) {
      out.last_touch = c.touch;
      const std::size_t i1 = force.index_at(c.touch - 20e-6), i2 = force.index_at(c.touch + 40e-6);
      std::fill(out.usable.begin() + static_cast<std::ptrdiff_t>(i1),
                out.usable.begin() + static_cast<std::ptrdiff_t>(i2), std::uint8_t{0});
      continue;
    }
    const bool small = !ring.empty() && r.fits[k].contact.peak.value < 1.5 * ring.amplitude_at(c.touch);
    if (small && keep_small) continue;
    const bool modelled = r.fits[k].shape && !small;
    for (std::size_t i = force.index_at(c.touch - 60e-6);
         i < force.size() && force.time(i) < c.release + 60e-6; ++i) {
      if (modelled)
        out.signal.value[i] -= r.fits[k].shape(force.time(i));
      else
        out.usable[i] = 0;
    }
  }
  return out;
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

std::vector<Pole> poles_of(const Ring& ring) {
  std::vector<Pole> p;
  for (const RingMode& m : ring.modes) p.push_back(m.pole);
  return p;
}

/// First identification, in the closed tail where only ring and a smooth force exist.
Ring ring_from_tail(const Force& f, const Round& r, double t_end, const ExtractOptions& o) {
  if (r.intervals.empty() || !r.intervals.back().open_ended()) return {};
  const Residual res = residual_of(f.signal, r, {}, t_end, false);
  const double from = res.last_touch + 150e-6;
  const RingInput in{res.signal, res.usable, from, from, std::min(from + o.ring_tail, t_end), f.noise};
  return grow_ring(in, tail_poles(in, o), o);
}

/// Window in which the core may have landed.
std::pair<double, double> onset_range(const Round& r, std::optional<double> seat, double t0, double t_end) {
  if (seat) return {std::max(*seat - 0.5e-3, t0), std::min(*seat + 0.5e-3, t_end)};
  const double first = r.intervals.front().touch;
  const double last = r.intervals.back().open_ended() ? r.intervals.back().touch : r.intervals.back().release;
  return {std::max({first - 4e-3, 0.5e-3, t0}), last + 150e-6};
}

double last_open(const Round& r) {
  const Interval& c = r.intervals.back();
  return c.open_ended() ? c.touch : c.release;
}

double open_level(const Force& f, const Round& r) {
  return std::max(0.1 * f.settled, r.levels.release);
}

/// The tail's ring, or the one seen in the open time when that leaves less (a mode that died before the tail).
Ring better_start(const Force& f, const Round& r, Ring ring, std::pair<double, double> range,
                  const ExtractOptions& o) {
  const auto [t1, t2] = range;
  const double level = open_level(f, r), to = std::max(last_open(r), t2);
  if (!ring.empty()) ring.onset = find_onset(f.signal, nullptr, ring, t1, t2);
  const OpenEnergy left = open_energy(f.signal, ring, t1, to, f.noise, level);
  if (left.samples < 40 || left.chi2 < 1.5 * left.samples) return ring;
  Ring other = ring_from_open_time(f.signal, t1, t2, to, f.noise, level, o);
  return !other.empty() && open_energy(f.signal, other, t1, to, f.noise, level).chi2 < 0.5 * left.chi2 ? other
                                                                                                       : ring;
}

/// Samples i1 .. i2 averaged in blocks down to about 200 kS/s: enough to choose between hypotheses.
Signal thinned(const Signal& s, std::size_t i1, std::size_t i2) {
  const auto m = std::max<std::size_t>(1, static_cast<std::size_t>(5e-6 / s.dt + 0.5));
  Signal out;
  out.t0 = s.time(i1) + 0.5 * static_cast<double>(m - 1) * s.dt;
  out.dt = static_cast<double>(m) * s.dt;
  for (std::size_t i = i1; i + m <= i2; i += m) {
    double sum = 0;
    std::uint8_t mask = mask_none;
    for (std::size_t k = i; k < i + m; ++k) sum += s.value[k], mask |= s.masked[k];
    out.value.push_back(sum / static_cast<double>(m));
    out.masked.push_back(mask);
  }
  return out;
}

/// The ring may have started inside a contact, where the residual says nothing: there the start is the one that lets
/// a pulse fit best. Steps of 1/16, then 1/64, then 1/256 of the fastest mode's period.
double onset_within_contact(const Force& f, const Round& r, Ring ring, double t1, double t2,
                            const ExtractOptions& o) {
  const double guess = ring.onset;
  for (std::size_t k = 0; k < r.intervals.size(); ++k) {
    const Interval& c = r.intervals[k];
    const double low = std::max(c.touch - 60e-6, t1),
                 high = std::min({c.release + 60e-6, t2, c.touch + 5e-3});
    if (c.open_ended() || guess < low - 100e-6 || guess > high + 100e-6) continue;
    const Signal& s = f.signal;
    const double from = c.touch - 2 * o.fit_margin, to = c.release + 2 * o.fit_margin;
    const Signal whole = thinned(s, s.index_at(from), s.index_at(to));
    const double noise = f.noise * std::sqrt(s.dt / whole.dt);
    const auto cost = [&](double onset) {
      Signal piece = whole;
      ring.onset = onset;
      ring.add_to(piece, -1.0);
      const auto smooth = gaussian_smooth(piece.value, r.levels.width / piece.dt);
      return pulse_cost({piece, smooth, noise, r.levels, o}, c, neighbours(r.intervals, k), true);
    };
    double fastest = 0;
    for (const RingMode& m : ring.modes) fastest = std::max(fastest, m.pole.hertz);
    double best = guess, lowest = cost(guess), step = std::max(1 / (16 * fastest), (high - low) / 60);
    for (double t = low; t <= high; t += step)
      if (const double v = cost(t); v < lowest) lowest = v, best = t;
    for (int level = 0; level < 2 && step > s.dt; ++level) {
      const double centre = best;
      step /= 4;
      for (int j = -4; j <= 4; ++j)
        if (const double v = cost(centre + j * step); v < lowest) lowest = v, best = centre + j * step;
    }
    return best;
  }
  return guess;
}

void fill_train(ContactTrain& train, const Round& r, const Force& f, double t_end, const ExtractOptions& o) {
  for (const ContactFit& fit : r.fits) {
    train.contacts.push_back(fit.contact);
    train.flags |= fit.contact.flags & (flag_clipped | flag_gap);
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

ForceAnalysis analyse_force(const Force& f, double t_end, std::optional<double> core_seat,
                            const ExtractOptions& o) {
  ForceAnalysis out;
  out.train.present = f.present;
  out.train.flags = f.flags;
  out.stripped = f.signal;
  if (!f.present) return out;

  Round round = find_contacts(f.signal, f.noise, f.settled, t_end, o);
  double first_open = 0;  // s: end of the open time before anything was taken out
  if (o.ring_modes > 0 && !round.intervals.empty()) {
    first_open = last_open(round);
    Ring ring = ring_from_tail(f, round, t_end, o);
    ring = better_start(f, round, std::move(ring), onset_range(round, core_seat, f.signal.t0, t_end), o);
    for (int k = 0; k < o.ring_rounds && !ring.empty(); ++k) {
      const std::size_t contacts = round.intervals.size();
      const Ring last = out.ring;
      const auto [t1, t2] = onset_range(round, core_seat, f.signal.t0, t_end);
      const Residual before = residual_of(f.signal, round, ring, t_end, true);
      ring.onset =
          find_onset(k == 0 ? f.signal : before.signal, k == 0 ? nullptr : &before.usable, ring, t1, t2);
      ring.onset = onset_within_contact(f, round, ring, t1, t2, o);
      // Carried back to its start, a mode that belongs to the closed contact grows beyond reason.
      const double limit = 1.5 * std::max(f.settled, 20 * f.noise);
      std::erase_if(ring.modes, [&](const RingMode& m) {
        return std::hypot(m.cosine, m.sine) * std::exp(-m.pole.decay * (ring.onset - ring.reference)) > limit;
      });
      if (ring.empty()) break;
      out.stripped = f.signal;
      ring.add_to(out.stripped, -1.0);
      const double noise = k == 0 ? f.noise : open_noise(out.stripped, round, ring, t_end, f.noise);
      round = find_contacts(out.stripped, noise, f.settled, t_end, o);
      out.ring = ring;
      const bool settled = contacts == round.intervals.size() && last.modes.size() == ring.modes.size() &&
                           std::abs(last.onset - ring.onset) < 3e-6;
      if (round.intervals.empty() || k + 1 == o.ring_rounds || (k > 0 && settled)) break;
      const Residual res = residual_of(f.signal, round, ring, t_end, false);
      const RingInput in{
          res.signal, res.usable, ring.onset, res.last_touch, std::min(res.last_touch + o.ring_tail, t_end),
          noise};
      ring = grow_ring(in, poles_of(ring), o);
    }
  }
  if (!out.ring.empty() && !round.intervals.empty() &&
      !lowers_energy(f.signal, out.ring, std::max(last_open(round), first_open), f.noise,
                     open_level(f, round))) {
    out.ring = {};
    out.stripped = f.signal;
  }
  round = find_contacts(out.stripped, out.ring.empty() ? f.noise : std::max(f.noise, round.noise), f.settled,
                        t_end, o, true);
  if (round.overlap) out.train.flags |= flag_ring_overlap;
  fill_train(out.train, round, f, t_end, o);
  summarise(out.train, o.merge_openings);
  return out;
}

}  // namespace powbench::dsp
