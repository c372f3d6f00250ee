#include "dsp/contacts/separate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "dsp/contacts/joint_ring.h"
#include "dsp/contacts/joint_start.h"
#include "dsp/contacts/landing.h"
#include "dsp/contacts/ring_tail.h"
#include "dsp/vibration/ring.h"

namespace powbench::dsp {

namespace {

constexpr double most_reduced = 3.0;     ///< of the joint fit: with more left the ring is not believed
constexpr double stage = 1.5e-3;         ///< s by which the window grows backwards
constexpr double usual_row = 5e-6;       ///< s: samples of the joint fit are averaged up to here
constexpr double badly_explained = 1.5;  ///< reduced sum of squares of a joint fit
constexpr double inside = 0.6e-3;  ///< s between the window's start and an onset that needs no earlier window

double last_event(const Round& r) {
  const Interval& c = r.intervals.back();
  return c.open_ended() ? c.touch : c.release;
}

constexpr double longest = 15e-3;          ///< s before the last touch in which a ring is looked for
constexpr std::size_t most_contacts = 25;  ///< more are no bounce train

/// Window in which the core may have landed.
std::pair<double, double> onset_range(const Round& r, const Measured& seat, double t0, double t_end) {
  if (seat.known()) {
    const double at = std::clamp(seat.value, t0, t_end);
    return {at, at};
  }
  const double last = last_event(r);
  return {std::max({r.intervals.front().touch - 4e-3, last - longest, 0.5e-3, t0}), last + 150e-6};
}

/// Samples of [t1, t2].
Signal cut(const Signal& s, double t1, double t2) {
  const auto i1 = static_cast<std::ptrdiff_t>(s.index_at(t1)),
             i2 = static_cast<std::ptrdiff_t>(s.index_at(t2));
  Signal out;
  out.dt = s.dt;
  out.t0 = s.time(static_cast<std::size_t>(i1));
  if (i2 <= i1) return out;
  out.value.assign(s.value.begin() + i1, s.value.begin() + i2);
  out.masked.assign(s.masked.begin() + i1, s.masked.begin() + i2);
  return out;
}

struct Search {
  const Force& force;
  double t_end;
  double last = 0;  ///< s: last event of the first detection
  std::pair<double, double> range;
  bool seat_known;
  double seat_u;  ///< s
  const ExtractOptions& options;
  /// What the ring is looked for in: all but what no pulse fits; open time and contacts that may be bent; these and the
  /// contact at rest; open time.
  enum class Use : std::uint8_t { all, bent, rested, open } use = Use::all;

  /// One round in the window from `from` on: detect on the stripped force, fit jointly, add modes.
  bool round(Separated& s, double from, std::pair<double, double> onset, int iterations,
             bool also_wide = true, bool rough = false) const {
    const double to = std::min(last + 2e-3, t_end);
    const Signal raw = cut(force.signal, from - 0.5e-3, to);
    Signal stripped = raw;
    take_out(s.model, stripped);
    Separated next = fitted(s, detect_round(stripped, force.noise, force.settled, to, options, false), from,
                            onset, iterations, rough);
    const bool unexplained = next.model.left_out > 0 || next.model.reduced() > 1.15;
    if (unexplained && also_wide && !seat_known) {
      Separated wide =
          fitted({}, detect_wide(raw, force.noise, force.settled, to, options), from, onset, iterations);
      if (wide.found && wide.model.cost() < next.model.cost()) next = std::move(wide);
    }
    if (next.round.intervals.empty()) return false;
    s = std::move(next);
    return true;
  }

  Separated fitted(const Separated& s, Round r, double from, std::pair<double, double> onset, int iterations,
                   bool rough = false) const {
    const bool complete = from <= range.first;  // the window reaches back to the landing
    std::erase_if(r.intervals, [&](const Interval& c) {
      if (c.touch > from + 40e-6) return false;
      if (c.release > from && !c.open_ended()) from = c.release + 60e-6;
      return c.touch <= from;
    });
    Separated out;
    out.from = from;
    out.round = std::move(r);
    if (out.round.intervals.empty() || out.round.intervals.size() > most_contacts) return out;
    JointInput in{force.signal,
                  force.noise,
                  t_end,
                  std::max(onset.first, from),
                  onset.second,
                  options,
                  from,
                  seat_known ? 10e-6 : usual_row,
                  seat_known,
                  false,
                  seat_known ? range.first - 3 * seat_u - 10e-6 : 0.0,
                  seat_known ? range.first + landing_time : 0.0};
    if (use == Use::open) in.open_below = 0.5 * force.settled;
    in.bend = use == Use::bent || use == Use::rested;
    in.settles = use == Use::all;
    if (use == Use::rested) in.rest = options.ring_tail - joint_rest;
    in.times_only = seat_known || rough;  // a ring alone comes out of it (separate_ring)
    if ((seat_known && !complete) || rough) in.enough = 1;
    const double limit = 1.5 * std::max(force.settled, 20 * force.noise);
    JointModel start = start_of(out.round, force.settled, s.model);
    if (start.ring.empty()) {  // whatever rings is found in what the contacts leave
      JointInput all = in;
      all.keep_all = true;
      start = fit_joint(all, std::move(start), iterations);
      if (start.reduced() > 1.1 && seed_ring(all, start, in.onset_from, in.onset_to)) {
        start = fit_joint(all, std::move(start), iterations);  // contacts are judged when all modes are in
        add_modes(all, start, limit);
      }
    }
    out.model = fit_joint(in, start, iterations);
    if (!bounded(out.model.ring, limit)) {  // better the ring that came in
      start.ring = s.model.ring;
      JointInput fixed = in;
      fixed.ring_fixed = true;
      out.model = fit_joint(fixed, std::move(start), iterations);
      out.found = !out.model.ring.empty() && bounded(out.model.ring, limit);
      if (!out.found) out.model.ring = {};
      return out;
    }
    if (!out.model.ring.empty() && !rough) {
      add_modes(in, out.model, limit);
      if (!seat_known)
        drop_stand_ins(in, out.model);
      else if (complete)
        drop_ring_pieces(in, out.model);
      if (use == Use::rested) keep_within_limits(in, out.model);
    }
    out.found = !out.model.ring.empty();
    return out;
  }

  /// A ring that died before its onset was reached is too faint to be carried back: looked for afresh in what the
  /// contacts of the whole record leave.
  void look_afresh(Separated& s, double from) const {
    Separated fresh;
    if (!round(fresh, from, range, 8) || !fresh.found) return;
    if (!s.found || fresh.model.cost() < s.model.cost()) s = std::move(fresh);
  }

  /// A contact that nothing describes may hold the onset: starts all along it. A rough fit says which are worth a
  /// whole one, of which the best is kept.
  void rescue(Separated& s, double from) const {
    constexpr std::size_t most_starts = 40, worth = 12;
    constexpr int glance = 4;  // iterations
    const Separated before = s;
    std::vector<std::pair<double, double>> starts;  // cost, s
    const auto fit_from = [&](double t, int iterations, bool rough) {
      Separated trial = before;
      trial.model.ring.onset = t;
      const std::pair near(std::max(t - 80e-6, range.first), std::min(t + 80e-6, range.second));
      if (!round(trial, from, near, iterations, false, rough)) trial.found = false;
      return trial;
    };
    for (const JointPulse& p : before.model.pulses) {
      if (p.modelled) continue;
      for (double t = p.shape.touch - 0.4e-3; t < p.shape.release + 0.15e-3 && starts.size() < most_starts;
           t += 0.1e-3) {
        const Separated trial = fit_from(t, glance, true);
        starts.emplace_back(trial.found ? trial.model.cost() : 1e300, t);
      }
    }
    std::sort(starts.begin(), starts.end());
    if (starts.size() > worth) starts.resize(worth);
    for (const auto& [cost, t] : starts) {
      if (!(cost < 1e300)) break;
      Separated trial = fit_from(t, 8, false);
      if (trial.found && trial.model.cost() < s.model.cost()) s = std::move(trial);
    }
  }

  /// An explanation by `what`, from `start`: taken where it reaches the noise, with no crest of the ring as a contact,
  /// and explains more than what is known. Not followed where its first round leaves too much, or what one before it
  /// left, `seen`. Returns what the first round leaves.
  double look(Separated& s, Use what, const Separated& start, double from, double seen = 1e300) const {
    constexpr double near = 0.5e-3, explained = 1.3, crest = 2, same = 0.1;  // same: of the cost
    Search open = *this;
    open.use = what;
    Separated other = start;
    if (!open.round(other, from, range, 8) || !other.found) return seen;
    const double first = other.model.cost(), at = other.model.ring.onset;
    if (!(other.model.reduced() < most_reduced) || std::abs(first - seen) < same) return first;
    open.settle(other, from, {std::max(at - near, range.first), std::min(at + near, range.second)});
    const auto is_crest = [&](const JointPulse& p) {
      return p.shape.peak <
             crest * other.model.ring.amplitude_at(std::max(p.shape.touch, other.model.ring.onset));
    };
    if (!other.found || !(other.model.reduced() < explained) ||
        !(other.model.cost_before_settling() < s.model.cost_before_settling()) ||
        std::any_of(other.model.pulses.begin(), other.model.pulses.end(), is_crest))
      return first;
    place_in_contact(other.model);
    other.open_time = other.whole = true;
    s = std::move(other);
    return first;
  }

  /// From the modes that the contact at rest shows, with the onset that they have in the whole force and with the one
  /// that is known. True when nothing is left to ask.
  bool look_from_rest(Separated& s, double from) const {
    constexpr double apart = 50e-6, nothing_left = 1.15;  // s; reduced sum of squares
    if (!s.model.rise) return false;
    const double known = s.found ? s.model.ring.onset : std::numeric_limits<double>::infinity();
    Separated start;
    Ring& ring = start.model.ring = ring_at_rest(force, s.model.rise->touch, t_end, options);
    if (ring.empty()) return false;
    const auto enough = [&] {
      return s.open_time && s.model.left_out <= s.model.settling_out && s.model.reduced() < nothing_left;
    };
    ring.onset = find_onset(force.signal, nullptr, ring, range.first, range.second);
    const double seen = look(s, Use::rested, start, from);
    if (enough() || !std::isfinite(known) || std::abs(ring.onset - known) < apart) return enough();
    ring.onset = known;
    look(s, Use::rested, start, from, seen);
    return enough();
  }

  /// A contact's own motion that no pulse and no rise describes bends the ring. So the ring is looked for beside bent
  /// contacts, and in open time alone where much is left, both without the first closed time. `known`: an explanation
  /// by the contact at rest, if there is one.
  void look_beside_contacts(Separated& s, const Separated& known, double from) const {
    const auto contact_left_out = [&] { return s.model.left_out > s.model.settling_out; };
    const Separated before = s;
    if (known.open_time && known.model.cost_before_settling() < s.model.cost_before_settling()) s = known;
    look(s, Use::bent, {}, from, look(s, Use::bent, before, from));
    if (!s.open_time) look(s, Use::rested, {}, from);
    if (before.model.reduced() > badly_explained && contact_left_out()) {
      look(s, Use::open, {}, from);
      if (s.open_time && contact_left_out()) look(s, Use::bent, Separated(s), from);
    }
  }

  /// A ring that starts in the contact at rest leaves nothing before it to explain. `s` must do better, where rows
  /// behind an earlier last touch count as left out.
  bool starts_at_rest(const Separated& s, Ring ring, double from) const {
    constexpr double margin = 20;  // twice a difference of 10 in log-likelihood
    Search rested = *this;
    rested.use = Use::rested;
    Separated late;
    ring.onset = range.second;
    late.model.ring = std::move(ring);
    if (!rested.round(late, from, {range.second, range.second}, 8) || !late.model.rise) return false;
    const double rows = (s.model.rise->touch - late.model.rise->touch) / std::max(usual_row, force.signal.dt);
    return late.model.cost_before_settling() + left_out_cost * rows < s.model.cost_before_settling() + margin;
  }

  /// An onset next to a contact that was left out may lie in it: where taking out the fast part of the ring leaves less
  /// of the fast part of the force.
  void place_in_contact(JointModel& m) const {
    constexpr double before = 50e-6, after = 100e-6, slow = 25e-6;  // s
    const double at = m.ring.onset;
    for (const JointPulse& p : m.pulses)
      if (!p.modelled && at > p.shape.touch - before && at < p.shape.release + after)
        m.ring.onset = find_onset(force.signal, nullptr, m.ring, p.shape.touch - before, at, slow);
  }

  /// Rounds in the whole window until nothing changes.
  void settle(Separated& s, double from, std::pair<double, double> onset) const {
    const int rounds = seat_known ? 1 : options.ring_rounds;
    for (int k = 0; k < rounds; ++k) {
      const Separated before = s;
      if (!round(s, from, onset, k == 0 ? 8 : 5) || !s.found) return;
      if (before.model.pulses.size() == s.model.pulses.size() &&
          std::abs(before.model.ring.onset - s.model.ring.onset) < 3e-6 &&
          before.model.ring.modes.size() == s.model.ring.modes.size())
        return;
    }
  }
};

}  // namespace

bool worth_stripping(const Separated& s, double noise) {
  if (!s.found) return false;
  if (s.model.reduced() < most_reduced) return true;
  // Much is left, but far less than the ring that goes.
  return !s.whole &&
         std::sqrt(s.model.reduced()) * noise < 0.2 * s.model.ring.amplitude_at(s.model.ring.onset);
}

bool convincing(const Separated& s) {
  if (!s.whole || !(s.model.reduced() < 1.12) || s.model.left_out > 0 || !s.model.rise) return false;
  double before = -1e300;
  for (const JointPulse& p : s.model.pulses) {
    if (!(p.shape.touch > before) || !std::isfinite(p.u_touch + p.u_release)) return false;
    before = p.shape.release;
  }
  return s.model.rise->touch > before && std::isfinite(s.model.rise->u_touch);
}

Separated without_ring(const Force& f, const Round& first, double t_end, const ExtractOptions& o) {
  Separated s;
  if (first.intervals.empty() || first.intervals.size() > most_contacts) return s;
  s.round = first;
  const JointInput in{f.signal, f.noise, t_end, first.intervals.front().touch, first.intervals.front().touch,
                      o};
  s.model = fit_joint(in, start_of(first, f.settled, {}), 12);
  s.whole = true;
  return s;
}

Separated separate_ring(const Force& f, const Round& unaided, const Measured& core_seat, double t_end,
                        const ExtractOptions& given) {
  Separated s;
  if (unaided.intervals.empty() || unaided.intervals.size() > most_contacts) return s;
  ExtractOptions o = given;
  Round first = unaided;
  if (core_seat.known()) {
    // The frame carries a share of the core's static force from the seat on: higher levels, the fit finds the edges.
    o.touch_share = std::max(o.touch_share, 0.2);
    o.release_share = std::max(o.release_share, 0.12);
    first = detect_round(f.signal, f.noise, f.settled, t_end, o, false);
    if (first.intervals.empty()) return s;
  }
  const Search search{f,
                      t_end,
                      last_event(first),
                      onset_range(first, core_seat, f.signal.t0, t_end),
                      core_seat.known(),
                      core_seat.known() && std::isfinite(core_seat.u) ? std::min(core_seat.u, 30e-6) : 0.0,
                      o};
  const auto [t1, t2] = search.range;
  s.model.ring = ring_from_tail(f, first, t_end, o);
  const double begin = std::min(t1, first.intervals.front().touch - joint_margin_before);
  const bool seat_known = core_seat.known();
  const double lowest = t1, step = seat_known ? 1.5 * stage : stage;
  for (double low = last_event(first); low > lowest;) {
    const double before = low;
    low = std::max(lowest, low - step);
    if (seat_known)
      s.model.ring.onset = t1;
    else if (!s.model.ring.empty() && (!s.found || s.model.ring.onset < s.from + inside))
      s.model.ring.onset =
          find_onset(f.signal, nullptr, s.model.ring, low, std::min(std::max(before, s.from) + inside, t2));
    if (!search.round(s, low, seat_known ? search.range : std::pair(low, t2), 6)) continue;
    if (s.found && s.model.ring.onset > s.from + inside && s.model.reduced() < 1.15) break;
  }
  // What is smaller than this is the shape of a contact or of the settled force, not vibration.
  const auto believable = [&] {
    return s.found &&
           s.model.ring.amplitude_at(s.model.ring.onset) >
               std::max(4 * f.noise * std::sqrt(std::min(1.0, f.signal.dt / 5e-6)), 0.015 * f.settled);
  };
  if (!seat_known && s.found && !believable()) {
    // Too faint to be vibration where it seems to start, so not followed to its start; afresh the same must be seen.
    const Ring faint = std::exchange(s, {}).model.ring;
    search.look_afresh(s, begin);
    if (s.found && !same_vibration(s.model.ring, faint)) return {};
  } else if (!seat_known && (!s.found || s.model.left_out > 0)) {
    search.look_afresh(s, begin);
  }
  if (!believable()) return {};
  if (seat_known) return s;  // what came before the core landed knows nothing of the ring
  const double onset = s.model.ring.onset;
  search.settle(s, begin, {std::max(onset - 0.5e-3, t1), std::min(onset + 0.5e-3, t2)});
  if (!believable()) return {};
  Separated rested = s;
  if (s.model.left_out > 0 && search.look_from_rest(rested, begin)) return rested;
  if (s.model.left_out > 0) {
    search.rescue(s, begin);
    const double at = s.model.ring.onset;
    search.settle(s, begin, {std::max(at - 0.2e-3, t1), std::min(at + 0.2e-3, t2)});
  }
  if (s.model.left_out > s.model.settling_out) search.look_beside_contacts(s, rested, begin);
  s.whole = s.found;
  return s;
}

Separated separate_at_rest(const Force& f, const Round& first, const Separated& bare, double t_end,
                           const ExtractOptions& o) {
  if (!bare.model.rise || convincing(bare)) return {};
  const Ring ring = ring_at_rest(f, bare.model.rise->touch, t_end, o);
  Separated s = bare;
  const Search search{f, t_end, last_event(first), onset_range(first, {}, f.signal.t0, t_end), false, 0.0, o};
  const double from = std::min(search.range.first, first.intervals.front().touch - joint_margin_before);
  // an opening that the ring hides would show the ring alone, which swings below zero
  if (!search.look_from_rest(s, from) || s.model.pulses.size() > bare.model.pulses.size()) return {};
  return search.starts_at_rest(s, ring, from) ? Separated{} : s;
}

}  // namespace powbench::dsp
