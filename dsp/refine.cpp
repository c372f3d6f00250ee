#include "dsp/refine.h"

#include <algorithm>
#include <cmath>

#include "dsp/dip.h"
#include "dsp/edge.h"
#include "dsp/shows.h"
#include "dsp/statistics.h"

namespace powbench::dsp {

namespace {

constexpr double longest_rise =
    1.5e-3;  // s from a touch to its first maximum, or from the last one to its release

/// s from t inwards (side +1: later) in which the force makes three quarters of its way to the first maximum, at least a quarter
/// of the time to it; looking no further than `reach`.
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
  const auto most = std::find_if(way.begin(), way.end(), [&](double v) { return v >= 0.75 * top; });
  return std::max(static_cast<double>(most - way.begin()) * force.dt, 0.25 * at);
}

/// An opening shows no force. What the levels took for one is looked at again: one smooth indentation through both edges says how
/// probable it is that the contact opened; with less than 0.6 (0.1 in loud noise) it is not listed. Where none explains the force, a least
/// force that stands clear of zero makes the two contacts one.
std::vector<Grazing> close_dips(std::vector<Contact>& contacts, const Signal& force, double noise) {
  constexpr double longest_dip = 0.6e-3, beside = 40e-6;  // s
  constexpr double sure = 0.003, loud = 0.03;
  std::vector<Grazing> out;
  for (std::size_t i = 0; i + 1 < contacts.size(); ++i) {
    Contact &a = contacts[i], &b = contacts[i + 1];
    const double gap = b.touch.value - a.release.value;
    if (!(gap < longest_dip)) continue;
    const double after = b.release.known() ? b.release.value - b.touch.value : longest_rise;
    const double closed = 0.7 * std::min(a.release.value - a.touch.value, after);
    const Dip dip = look_at_dip(force, a.release.value, b.touch.value, closed, noise);
    double opened = dip.opened;
    if (!dip.known) {
      const double margin = std::max(beside, 0.5 * gap);
      const Measured least =
          locate_extreme(force, a.release.value - margin, b.touch.value + margin, -1, noise);
      opened = least.known() && least.value > least.u ? 0 : 1;
    }
    // where the noise hides how the force bends, what two levels saw apart stays apart unless the dip speaks against it
    const bool listed = opened > (dip.noise > loud ? 0.1 : 0.6);
    const bool uncertain = std::min(opened, 1 - opened) > sure;
    if (uncertain) (listed ? b : a).flags |= flag_grazing;
    if (uncertain) out.push_back({i, a.touch.value, b.touch.value, a.release.value, opened, listed});
    if (listed) continue;
    if (!(a.peak.value > b.peak.value)) a.peak = b.peak;
    a.impulse = {a.impulse.value + b.impulse.value, std::hypot(a.impulse.u, b.impulse.u)};
    if (!b.release.known()) a.impulse = {};
    a.release = b.release;
    a.flags |= b.flags;
    contacts.erase(contacts.begin() + static_cast<std::ptrdiff_t>(i + 1));
    --i;
  }
  return out;
}

/// s from the edge inwards (side +1: later) until the calm force first stands at `level`; no further than 0.5 ms.
double time_to(const CalmForce& calm, const Signal& force, double edge, int side, double level) {
  constexpr double farthest_rise = 0.5e-3;  // s
  const auto n = static_cast<std::ptrdiff_t>(force.size());
  const auto at = static_cast<std::ptrdiff_t>(force.index_at(edge));
  const auto reach = static_cast<std::ptrdiff_t>(farthest_rise / force.dt);
  std::ptrdiff_t i = at;
  while (i >= 0 && i < n && std::abs(i - at) <= reach && calm.value[static_cast<std::size_t>(i)] < level)
    i += side;
  return static_cast<double>(std::abs(i - at)) * force.dt;
}

/// N: how far the calm force swings below zero between two times; 0 where no swing stands out of the noise.
double swing_below(const CalmForce& calm, const Signal& force, double from, double to) {
  constexpr double clear = 6;  // standard deviations
  double lowest = 0;
  for (std::size_t i = force.index_at(from); i < std::min(force.index_at(to), force.size()); ++i)
    lowest = std::min(lowest, calm.value[i]);
  return lowest > -clear * calm.noise ? 0 : -lowest;
}

/// s by which vibration that is still in the force may move an edge: as far as it swings below zero on the open side, so far the force may
/// have risen unseen. 0 where nothing swings.
double moved_by_vibration(const CalmForce& calm, const Signal& force, double edge, int side) {
  constexpr double beside = 0.5e-3;  // s
  const double swing = side > 0 ? swing_below(calm, force, edge - beside, edge + force.dt)
                                : swing_below(calm, force, edge, edge + beside);
  return swing > 0 ? time_to(calm, force, edge, side, swing) / std::sqrt(3.0) : 0;
}

/// What the force beside a contact says.
struct Beside {
  EdgeAnswer touch, release;
  Measured peak;
};

/// Do the shapes that describe whole contacts agree with what stands beside the edges? The sum over all edges of the squared difference
/// over what it may be; two estimates of one time, the better of which uses all of the other's samples, differ by
/// u^2(worse) - u^2(better). One answer for a record: all its contacts have the same pads.
struct Agreement {
  double squares = 0, edges = 0, weight = 0;

  void add(const Measured& shape, const EdgeAnswer& beside) {
    if (!beside.known || !shape.known()) return;
    const double u = beside.time.u, apart = shape.value - beside.time.value;
    squares += apart * apart / std::max(u * u - shape.u * shape.u, 0.25 * u * u);
    edges += 1;
  }
  bool holds() const { return edges > 0 && squares < edges * reduced_chi2_quantile(0.995, edges); }
  /// s of `u` that the agreement leaves open: a shape that is wrong by less than that is not found out.
  double open(double u) const { return 0.4 * u / std::sqrt(edges); }
};

/// Touch of a contact that stays closed. Its shape is a guess about what comes afterwards: the further it is from what the edge says,
/// the less it counts.
Measured touch_that_lasts(const Contact& c, const EdgeAnswer& beside) {
  if (!beside.known) return c.touch;
  const Measured own = beside.time;
  const double apart = c.touch.value - own.value;
  const double guess = std::hypot(std::hypot(c.touch.u, 0.5 * own.u), apart), all = std::hypot(own.u, guess);
  return {own.value + own.u * own.u / (all * all) * apart, own.u * guess / all};
}

}  // namespace

std::vector<Grazing> refine_contacts(std::vector<Contact>& contacts, const Signal& force, double noise,
                                     const ExtractOptions& o) {
  if (contacts.empty() || !(noise > 0)) return {};
  const CalmForce calm = calm_force(force, noise, o);
  std::vector<Grazing> grazing = close_dips(contacts, force, noise);
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
                                              std::max(closed, 3 * force.dt), noise});
      // a dozen samples that take more than half of a contact are no edge any more: its shape as a whole says more
      const bool half = c.release.known() && answer.span > 0.55 * (release - touch);
      answer.known = answer.known && !(half && answer.span < 12.5 * force.dt);
      return answer;
    };
    Beside& b = beside[i];
    b.touch = ask(touch, +1, touch - before);
    if (c.release.known()) {
      b.release = ask(release, -1, after - release);
      if (!(c.flags & flag_clipped)) b.peak = locate_extreme(force, touch, release, +1, noise);
    }
    if (c.flags & flag_poor_fit) continue;
    if (!c.release.known()) continue;
    agreement.add(c.touch, b.touch);
    agreement.add(c.release, b.release);
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    const Contact was = c;
    const Beside& b = beside[i];
    const bool shape = !(c.flags & flag_poor_fit) && agreement.holds() && c.release.known();
    const auto take = [&](Measured& time, const EdgeAnswer& answer) {
      if (!answer.known) return;
      if (shape)
        time.u = std::hypot(time.u, agreement.open(answer.time.u));
      else
        time = answer.time;
    };
    if (c.release.known())
      take(c.touch, b.touch), take(c.release, b.release);
    else
      c.touch = touch_that_lasts(c, b.touch);
    for (Measured* edge : {&c.touch, &c.release}) {
      if (!edge->known()) continue;
      const bool touch = edge == &c.touch;
      if ((c.flags & flag_poor_fit) &&
          !(touch ? b.touch : b.release).known)  // neither shape nor law dates it
        edge->u = std::max(edge->u, 0.5 * rise_of(calm, force, edge->value, touch ? +1 : -1, 0.5e-3));
      const double moved = moved_by_vibration(calm, force, edge->value, touch ? +1 : -1);
      if (moved > edge->u) c.flags |= flag_ring_overlap;
      edge->u = std::hypot(edge->u, moved);
    }
    if (b.peak.known()) c.peak = b.peak;
    const double before = i > 0 ? contacts[i - 1].release.value : force.t0;
    if (c.release.known() && !(c.release.value > c.touch.value && c.touch.value >= before)) {
      c = was;
      c.flags |= flag_poor_fit;
    } else if (!shape && b.touch.followed && (!c.release.known() || b.release.followed)) {
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

void doubt_stripping(std::vector<Contact>& contacts, const Signal& unaided, const Signal& stripped,
                     const Ring& ring, double noise, const ExtractOptions& o) {
  constexpr double left = 0.15;                  // of the vibration taken out, that may still be there
  constexpr double near = 1.5e-3, early = 1e-3;  // s beside an edge; before the onset found
  const CalmForce calm = calm_force(stripped, noise, o);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Contact& c = contacts[i];
    const double before = i > 0 ? contacts[i - 1].release.value : stripped.t0;
    const double after = i + 1 < contacts.size() ? contacts[i + 1].touch.value : stripped.end();
    const double closed = c.release.known() ? 0.4 * (c.release.value - c.touch.value) : o.edge_window;
    const auto residue = [&](double t) {
      return std::max(left * ring.amplitude_at(std::max(t, ring.onset)),
                      swing_below(calm, stripped, t - near, t + near));
    };
    const auto doubt = [&](Measured& edge, int side, double free) {
      if (!edge.known() || edge.value < ring.onset - early) return;
      double moved = time_to(calm, stripped, edge.value, side, residue(edge.value));
      const EdgeQuestion q{edge.value, side, std::clamp(0.8 * free, 2 * stripped.dt, o.fit_margin),
                           std::max(std::min(closed, o.edge_window), 8 * stripped.dt), noise};
      const EdgeAnswer with = locate_edge(unaided, q), without = locate_edge(stripped, q);
      if (with.known && without.known) moved = std::hypot(moved, with.time.value - without.time.value);
      moved /= std::sqrt(3.0);
      if (moved > edge.u) c.flags |= flag_ring_overlap;
      edge.u = std::hypot(edge.u, moved);
    };
    const double end = c.release.known() ? c.release.value : c.touch.value + o.edge_window;
    if (c.peak.known() && end > ring.onset) c.peak.u = std::hypot(c.peak.u, residue(end));
    doubt(c.touch, +1, c.touch.value - before);
    doubt(c.release, -1, after - c.release.value);
  }
}

}  // namespace powbench::dsp
