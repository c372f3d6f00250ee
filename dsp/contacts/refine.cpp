#include "dsp/contacts/refine.h"

#include <algorithm>
#include <cmath>

#include "dsp/contacts/crest.h"
#include "dsp/contacts/edge.h"
#include "dsp/contacts/extreme.h"
#include "dsp/contacts/one_law.h"
#include "dsp/contacts/openings.h"
#include "dsp/contacts/shows.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double worth_a_flag = 20e-6;  // s that vibration may move an edge; less stands in u alone
constexpr double far_from_law =
    9;  // reduced sum of squares: a misfit of more than three times the noise; less stands in u
/// Of the closed time, or of four times the last fall (`rise_of`; a half sine's duration) where a contact rests first:
/// by so much the losses of a pad date its release otherwise than the laws of an edge. Where no noise hides it
/// (1 MS/s), 5.7 % of the releases of the tuning seeds lay beyond 3 u without it.
constexpr double of_a_loss = 1.5e-3, falls = 4;
/// s; beside an opening the laws of an edge bend within a time of the opening's own length: u grows by the root of
/// 1 + (bend / opening)^2. On the tuning seeds, error over u is 2.0 up to 0.1 ms and 1.35 up to 0.2 ms without it.
constexpr double bend = 40e-6;
constexpr double sticking = 150e-6;   // s that a pad may pull while it breaks
constexpr double still_there = 1e-3;  // s that vibration lasts at least

/// s from t inwards (side +1: later) in which the force makes three quarters of its way to the first maximum, at
/// least a quarter of the time to it; looking no further than `reach`.
double rise_of(const CalmForce& calm, const Signal& force, double t, int side, double reach) {
  const auto n = static_cast<std::ptrdiff_t>(force.size());
  double top = -1e300, at = 0;
  std::vector<double> way;
  for (auto i = static_cast<std::ptrdiff_t>(force.index_at(t)); i >= 0 && i < n; i += side) {
    const double away = side * (force.time(static_cast<std::size_t>(i)) - t);
    const double v = calm.value[static_cast<std::size_t>(i)];
    if (away > reach) break;
    way.push_back(v);
    if (v > top) top = v, at = away;
    if (v < top - std::max(5 * calm.noise, 0.05 * top)) break;
  }
  const auto high = std::find_if(way.begin(), way.end(), [&](double v) { return v >= 0.75 * top; });
  return std::max(static_cast<double>(high - way.begin()) * force.dt, 0.25 * at);
}

/// s by which vibration that is still in the force may move an edge: as far as it swings below zero on the open side,
/// so far the force may have risen unseen. 0 where nothing swings. `after_release`: s that pass before a release's
/// open side is looked at.
double moved_by_vibration(const CalmForce& calm, const Signal& force, double edge, int side,
                          double after_release) {
  constexpr double beside = 0.5e-3;  // s
  const double swing = side > 0
                           ? swing_below(calm, force, edge - beside, edge + force.dt)
                           : swing_below(calm, force, edge + after_release, edge + after_release + beside);
  return swing > 0 ? time_to(calm, force, edge, side, swing) / std::sqrt(3.0) : 0;
}

/// s by which an edge lies outside the place that the rise behind it points to. Vibration that starts just before a
/// touch, or is on its way up after a release, has one sign there and is no different from a contact's foot; only the
/// rise beyond it is surely contact. 0 where both agree, or where the foot is no longer than that of a round pad.
double foot_of(const CalmForce& calm, const EdgeForce& film, double edge, int side, double reach, double open,
               double u) {
  const Signal& force = film.signal;
  constexpr double low = 0.2, high = 0.75;  // of the largest force
  constexpr double round = 0.75;            // time below `low` over time to `high`: 0.7 of F ~ t^1.5
  const auto n = static_cast<std::ptrdiff_t>(force.size());
  const auto first = static_cast<std::ptrdiff_t>(force.index_at(edge));
  if (first >= n) return 0;  // an edge beyond the record has nothing behind it
  const auto count = static_cast<std::ptrdiff_t>(reach / force.dt);
  const auto at = [&](std::ptrdiff_t k) { return calm.value[static_cast<std::size_t>(first + side * k)]; };
  const auto last = side > 0 ? std::min(count, n - 1 - first) : std::min(count, first);
  double top = 0;
  for (std::ptrdiff_t k = 0; k <= last; ++k) top = std::max(top, at(k));
  std::ptrdiff_t risen = 0, foot = 0;
  while (risen <= last && at(risen) < high * top) ++risen;
  for (std::ptrdiff_t k = 0; k <= std::min(risen, last); ++k)
    if (at(k) < low * top) foot = k;
  if (!(top > 10 * calm.noise) || risen > last ||
      static_cast<double>(foot) < round * static_cast<double>(risen - foot))
    return 0;
  const double span = static_cast<double>(risen) * force.dt, skip = static_cast<double>(foot) * force.dt;
  const EdgeAnswer beyond = locate_edge_beyond(force, {edge, side, open, span, film.noise, film.delay}, skip);
  if (!beyond.known) return 0;
  const double apart = side * (beyond.time.value - edge);
  return apart > 3 * std::hypot(beyond.time.u, u) ? apart : 0;
}

/// The edge is dated by a law, and what that leaves is in its uncertainty.
bool near_law(const EdgeAnswer& e) {
  return e.known && (e.followed || e.reduced_chi2 < far_from_law);
}

/// What the force beside a contact says.
struct Beside {
  EdgeAnswer touch, release;
  Measured peak;
  double fall = 0;  ///< s, of the force before the release
};

/// Do the shapes that describe whole contacts agree with what stands beside the edges? The sum over all edges of the
/// squared difference over what it may be; two estimates of one time, the better of which uses all of the other's
/// samples, differ by u^2(worse) - u^2(better). A wrong shape makes all contacts too wide or all too narrow, each by
/// less than it may be: the signed sum shows it. One answer for a record: all its contacts have the same pads.
struct Agreement {
  double squares = 0, wider = 0, edges = 0;

  /// `side`: +1 touch, -1 release.
  void add(const Measured& shape, const EdgeAnswer& beside, int side) {
    if (!beside.known || !shape.known()) return;
    const double u = beside.time.u, apart = shape.value - beside.time.value;
    const double may_be = std::max(u * u - shape.u * shape.u, 0.25 * u * u);
    squares += apart * apart / may_be;
    wider -= side * apart / std::sqrt(may_be);
    edges += 1;
  }
  /// Of all edges together, in standard deviations.
  double width() const { return std::abs(wider) / std::sqrt(edges); }
  bool holds() const {
    constexpr double share = 0.995, widest = 2.5;
    return edges > 0 && squares < edges * reduced_chi2_quantile(share, edges) && width() < widest;
  }
  /// s of `u` that the agreement leaves open: a shape that is wrong by less than that is not found out.
  double open(double u) const {
    constexpr double least = 0.2, chance = 1;
    return std::max(least, width() - chance) * u / std::sqrt(edges);
  }
};

void doubt_beside(EdgeAnswer& edge, double opening) {
  if (edge.known && opening > 0) edge.time.u *= std::hypot(1.0, bend / opening);
}

/// Touch of a contact that stays closed. Its shape is a guess about what comes afterwards: the further it is from what
/// the edge says, the less it counts, and only half of the certainty that it adds is taken.
Measured touch_that_lasts(const Contact& c, const EdgeAnswer& beside) {
  if (!beside.known) return c.touch;
  const Measured own = beside.time;
  const double apart = c.touch.value - own.value, guess = std::hypot(c.touch.u, own.u, apart),
               all = std::hypot(own.u, guess), both = guess / all;
  return {own.value + own.u * own.u / (all * all) * apart, own.u * std::sqrt((1 + both * both) / 2)};
}

/// An edge that was not dated with the amplifier's response: it shows up to a delay D early on rising and late on
/// falling. Uniform in between: D / sqrt(3).
void admit_amplifier(Measured& edge, double delay) {
  edge.u = std::hypot(edge.u, delay / std::sqrt(3.0));
}

}  // namespace

std::vector<Grazing> refine_contacts(std::vector<Contact>& contacts, const EdgeForce& film,
                                     const ExtractOptions& o) {
  const Signal& force = film.signal;
  const double noise = film.noise, white = film.white;
  if (contacts.empty() || !(noise > 0)) return {};
  const CalmForce calm = calm_force(force, noise, o);
  const CalmForce quiet{calm.value, calm.noise * white / noise};  // swings stand out of this
  std::vector<Grazing> grazing =
      close_dips(contacts, quiet, force, noise, noise > 2 * white ? 1.4 * noise : 0.0, film.wander,
                 film.vibrating == nullptr && noise < 1.2 * white);
  doubt_dips(contacts, grazing, force, noise, film.wander);
  std::vector<Beside> beside(contacts.size());
  Agreement agreement;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const double touch = c.touch.value, release = c.release.value, end = force.end();
    const double before = i > 0 ? contacts[i - 1].release.value : force.t0;
    const double after = i + 1 < contacts.size() ? contacts[i + 1].touch.value : end;
    const double stop = c.release.known() ? release : std::min(touch + longest_rise, end);
    const auto ask = [&](double near, int side, double free) {
      const double closed = rise_of(calm, force, near, side, std::min(longest_rise, stop - touch));
      EdgeAnswer answer = locate_edge(force, {near, side, std::clamp(0.8 * free, 2 * force.dt, o.fit_margin),
                                              std::max(closed, 3 * force.dt), noise, film.delay});
      // a dozen samples that take more than half of a contact are no edge any more: its shape as a whole says more
      const bool half = c.release.known() && answer.span > 0.55 * (release - touch);
      answer.known = answer.known && !(half && answer.span < 12.5 * force.dt);
      return answer;
    };
    Beside& b = beside[i];
    b.touch = ask(touch, +1, touch - before);
    if (c.release.known()) {
      b.release = ask(release, -1, after - release);
      b.fall = rise_of(calm, force, release, -1, std::min(longest_rise, stop - touch));
      if (!(c.flags & flag_clipped)) b.peak = locate_extreme(force, touch, release, +1, noise);
    }
    if (c.flags & flag_poor_fit) continue;
    if (!c.release.known()) continue;
    agreement.add(c.touch, b.touch, +1);  // each edge by itself: what the touches say about the law follows
    agreement.add(c.release, b.release, -1);
  }
  std::vector<EdgeAnswer*> touches;
  for (Beside& b : beside)
    if (b.touch.known) touches.push_back(&b.touch);
  agree_on_law(touches);
  std::vector<double> opening(contacts.size() + 1, 1.0);  // s, before each contact; and after the last
  for (std::size_t i = 1; i < contacts.size(); ++i)
    opening[i] = contacts[i].touch.value - contacts[i - 1].release.value;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    doubt_beside(beside[i].touch, opening[i]), doubt_beside(beside[i].release, opening[i + 1]);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    const Contact was = c;
    const Beside& b = beside[i];
    // a shape knows nothing of the amplifier's low-pass: with one, the edges alone date
    const bool shape =
        !(film.delay > 0) && !(c.flags & flag_poor_fit) && agreement.holds() && c.release.known();
    const auto take = [&](Measured& time, const EdgeAnswer& answer, double beyond_law) {
      if (!answer.known) return;
      if (shape)
        time.u = std::hypot(time.u, agreement.open(answer.time.u));
      else
        time = {answer.time.value, std::hypot(answer.time.u, beyond_law)};
    };
    if (c.release.known())
      take(c.touch, b.touch, 0),
          take(c.release, b.release,
               of_a_loss * std::min(was.release.value - was.touch.value, falls * b.fall));
    else if (film.delay > 0)
      take(c.touch, b.touch, 0);
    else
      c.touch = touch_that_lasts(c, b.touch);
    if (film.delay > 0) {
      if (!b.touch.known) admit_amplifier(c.touch, film.delay);
      if (c.release.known() && !b.release.known) admit_amplifier(c.release, film.delay);
    }
    for (Measured* edge : {&c.touch, &c.release}) {
      if (!edge->known()) continue;
      const bool touch = edge == &c.touch;
      if ((c.flags & flag_poor_fit) &&
          !(touch ? b.touch : b.release).known)  // neither shape nor law dates it
        edge->u = std::max(edge->u, 0.5 * rise_of(calm, force, edge->value, touch ? +1 : -1, 0.5e-3));
      // a pad that pulls while it breaks blurs the release too, but is no vibration
      const double by_either = moved_by_vibration(quiet, force, edge->value, touch ? +1 : -1, 0);
      double moved = moved_by_vibration(quiet, force, edge->value, touch ? +1 : -1, sticking);
      const double open =
          touch ? c.touch.value - (i > 0 ? contacts[i - 1].release.value : force.t0)
                : (i + 1 < contacts.size() ? contacts[i + 1].touch.value : force.end()) - c.release.value;
      const double end_of = c.release.known() ? c.release.value - c.touch.value : longest_rise;
      const double foot = foot_of(quiet, film, edge->value, touch ? +1 : -1, std::min(longest_rise, end_of),
                                  std::clamp(0.8 * open, 2 * force.dt, o.fit_margin), edge->u);
      moved = std::hypot(moved, foot / std::sqrt(3.0));
      if (moved > std::max(edge->u, worth_a_flag)) c.flags |= flag_ring_overlap;
      edge->u = std::hypot(edge->u, std::hypot(by_either, foot / std::sqrt(3.0)));
      if (!film.vibrating) continue;
      const EdgeInVibration in =
          look_at_edge(*film.vibrating, force, quiet,
                       {edge->value, touch ? +1 : -1, std::min(longest_rise, end_of), open});
      const Measured vibrating = in.of(*edge, touch ? +1 : -1);
      if (vibrating.u > std::max(edge->u, worth_a_flag)) c.flags |= flag_ring_overlap;
      *edge = vibrating;
    }
    if (b.peak.known()) c.peak = b.peak;
    // what swings below zero in the open time beside a contact is in its peak too
    const double stop = c.release.known() ? c.release.value : c.touch.value;
    c.peak.u =
        std::hypot(c.peak.u, std::max(swing_below(quiet, force, c.touch.value - still_there, c.touch.value),
                                      swing_below(quiet, force, stop + sticking, stop + still_there)));
    const double before = i > 0 ? contacts[i - 1].release.value : force.t0;
    if (c.release.known() && !(c.release.value > c.touch.value && c.touch.value >= before)) {
      c = was;
      c.flags |= flag_poor_fit;
    } else if (!shape && near_law(b.touch) && (!c.release.known() || near_law(b.release))) {
      c.flags &= ~static_cast<std::uint32_t>(flag_poor_fit);  // each edge follows a law
    }
  }
  for (Grazing& g : grazing) {
    Contact& c = contacts[g.contact];
    g.before = c.touch.value;
    if (g.listed) g.after = contacts[g.contact + 1].touch.value;
    // the release is another one where the dip is not what it was taken for
    const Measured& other = g.listed ? contacts[g.contact + 1].release : c.release;
    const double apart = other.known() ? other.value - (g.listed ? c.release.value : g.release) : 0.0;
    c.release.u = std::hypot(c.release.u, g.share() * apart);
  }
  return grazing;
}

double hidden_by_vibration(const EdgeForce& film, double edge, int side, double amplitude,
                           const ExtractOptions& o) {
  return time_to(calm_force(film.signal, film.white, o), film.signal, edge, side, amplitude);
}

void doubt_stripping(std::vector<Contact>& contacts, const Signal& unaided, const EdgeForce& film,
                     const Ring& ring, const ExtractOptions& o) {
  const Signal& stripped = film.signal;
  constexpr double left = 0.15;                  // of the vibration taken out, that may still be there
  constexpr double near = 1.5e-3, early = 1e-3;  // s beside an edge; before the onset found
  const CalmForce calm = calm_force(stripped, film.white, o);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    const double before = i > 0 ? contacts[i - 1].release.value : stripped.t0;
    const double after = i + 1 < contacts.size() ? contacts[i + 1].touch.value : stripped.end();
    const double closed = c.release.known() ? 0.4 * (c.release.value - c.touch.value) : o.edge_window;
    const auto residue = [&](double t) {
      return std::max(left * ring.amplitude_at(std::max(t, ring.onset)),
                      swing_below(calm, stripped, t - near, t + near));
    };
    const auto hidden_by = [&](double t, int side) {
      return time_to(calm, stripped, t, side, ring.amplitude_at(std::max(t, ring.onset)));
    };
    const auto doubt = [&](Measured& edge, int side, double free) {
      if (!edge.known() || edge.value < ring.onset - early) return;
      double moved = time_to(calm, stripped, edge.value, side, residue(edge.value));
      const EdgeQuestion q{edge.value,
                           side,
                           std::clamp(0.8 * free, 2 * stripped.dt, o.fit_margin),
                           std::max(std::min(closed, o.edge_window), 8 * stripped.dt),
                           film.noise,
                           film.delay};
      if (const EdgeAnswer with = locate_edge(unaided, q); with.known)
        moved =
            std::hypot(moved, std::min(std::abs(with.time.value - edge.value), hidden_by(edge.value, side)));
      moved /= std::sqrt(3.0);
      if (moved > std::max(edge.u, worth_a_flag)) c.flags |= flag_ring_overlap;
      edge.u = std::hypot(edge.u, moved);
    };
    const double end = c.release.known() ? c.release.value : c.touch.value + o.edge_window;
    if (c.peak.known() && end > ring.onset) c.peak.u = std::hypot(c.peak.u, residue(end));
    doubt(c.touch, +1, c.touch.value - before);
    doubt(c.release, -1, after - c.release.value);
  }
}

}  // namespace powbench::dsp
