#include "dsp/contacts/openings.h"

#include <algorithm>
#include <cmath>

#include "dsp/contacts/dip.h"
#include "dsp/contacts/extreme.h"

namespace powbench::dsp {

namespace {

constexpr double sure = 0.003, longest_dip = 0.6e-3;  // probability; s

/// N: amplitude of the vibration that is still in the force, where an opening may be no more than a single trough of
/// it; else 0. An opening lets the vibration swing on about zero: up by most of its amplitude and down again before the
/// contact closes. Where it does not, a low contact force and a trough look the same. `vibration`: N, its amplitude
/// where it is known to be there, else 0.
double one_trough(const CalmForce& quiet, const Signal& force, const Contact& before, const Contact& after,
                  double vibration) {
  constexpr double half_a_period = 0.4e-3;  // s, of the slowest core vibration
  if (after.touch.value - before.release.value > half_a_period) return 0;
  const double amplitude =
      std::max(vibration, swing_below(quiet, force, before.release.value, after.touch.value));
  if (!(amplitude > 0)) return 0;
  const std::size_t first = force.index_at(before.release.value), last = force.index_at(after.touch.value);
  double low = 1e300,
         high = -1e300;  // lowest so far; highest since the force has come up by most of the amplitude
  std::size_t up = last;
  for (std::size_t i = first; i < last; ++i) {
    const double v = quiet.value[i];
    if (v < low) low = v, up = last;
    if (v > low + 0.7 * amplitude) high = std::max(high, v), up = std::min(up, i);
    if (v < high - 0.5 * amplitude) return 0;
  }
  // a pad that pulls when it breaks leaves zero behind it
  return 4 * (last - up) < last - first ? amplitude : 0;
}

/// Runs of samples, first and one behind the last, in which the mean of three does not stand above `level`, with force
/// before and behind.
struct Run {
  std::size_t first = 0, end = 0;
};

std::vector<Run> low_runs(const Signal& force, std::size_t first, std::size_t end, double level) {
  std::vector<Run> runs;
  bool risen = false, low = false;
  for (std::size_t i = std::max<std::size_t>(first, 1); i + 1 < std::min(end, force.size()); ++i) {
    const bool below = force.value[i - 1] + force.value[i] + force.value[i + 1] < 3 * level;
    if (!below && low) runs.back().end = i;
    if (below && !low && risen) runs.push_back({i, end});
    low = below && risen;
    risen = risen || !below;
  }
  if (low) runs.pop_back();  // the release
  return runs;
}

/// Longest stretch, s, of [from, to] in which the mean of three samples stands below `level`.
double longest_below(const Signal& force, double from, double to, double level) {
  std::size_t longest = 0, run = 0;
  const std::size_t first = std::max<std::size_t>(force.index_at(from), 1), end = force.index_at(to);
  for (std::size_t i = first; i < end && i + 1 < force.size(); ++i) {
    run = force.value[i - 1] + force.value[i] + force.value[i + 1] < 3 * level ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return static_cast<double>(longest) * force.dt;
}

/// The force rests at zero between steep flanks. A dip that only grazes zero is narrower there than higher up: of the
/// width at a height l1 a parabola has sqrt(l0 / l1) at l0, below 0.45 here; what keeps `flat` of it is an opening.
bool rests_at_zero(const Signal& force, const Contact& a, const Contact& b, double noise, double wander) {
  constexpr double high = 0.3, apart = 5, flat = 0.75, least = 60e-6, beside = 0.3e-3;  // of the peak; s
  if (!a.peak.known() || !b.peak.known()) return false;
  const double low = 3 * noise / std::sqrt(3.0) + 2 * wander,
               top = high * std::min(a.peak.value, b.peak.value);
  if (!(top > apart * low)) return false;
  const double from = a.release.value - beside, to = b.touch.value + beside;
  const double open = longest_below(force, from, to, low);
  return open > least && open > flat * longest_below(force, from, to, top);
}

}  // namespace

std::vector<Grazing> close_dips(std::vector<Contact>& contacts, const CalmForce& quiet, const Signal& force,
                                double noise, double vibration, double wander, bool still) {
  constexpr double beside = 40e-6;  // s
  constexpr double loud = 0.03, trough = 0.3;
  std::vector<Grazing> out;
  for (std::size_t i = 0; i + 1 < contacts.size(); ++i) {
    Contact &a = contacts[i], &b = contacts[i + 1];
    const double gap = b.touch.value - a.release.value;
    if (!(gap < longest_dip)) continue;
    const double after = b.release.known() ? b.release.value - b.touch.value : longest_rise;
    const double closed = 0.7 * std::min(a.release.value - a.touch.value, after);
    const Dip dip = look_at_dip(force, a.release.value, b.touch.value, closed, noise, wander);
    double opened = dip.opened;
    if (!dip.known) {
      const double margin = std::max(beside, 0.5 * gap);
      const Measured least =
          locate_extreme(force, a.release.value - margin, b.touch.value + margin, -1, noise);
      opened = least.known() && least.value > least.u + 2 * wander ? 0 : 1;
    }
    if (opened < 1 && still && rests_at_zero(force, a, b, noise, wander)) opened = 1;
    if (const double moved = one_trough(quiet, force, a, b, vibration); moved > 0) {
      // an opening beyond doubt, though the vibration moves the zero of the dip, is no trough of it
      const Dip with =
          look_at_dip(force, a.release.value, b.touch.value, closed, noise, std::hypot(wander, moved));
      if (!(dip.known && dip.sure && with.known && with.sure))
        opened = std::clamp(opened, trough, 1 - trough);
    }
    // where the noise hides how the force bends, what two levels saw apart stays apart unless the dip speaks against it
    const bool listed = opened >= (dip.noise > loud ? trough : 0.5);
    const bool uncertain = std::min(opened, 1 - opened) > sure;
    if (uncertain) (listed ? b : a).flags |= flag_grazing;
    if (listed) b.probability *= opened;
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

void doubt_dips(std::vector<Contact>& contacts, std::vector<Grazing>& grazing, const Signal& force,
                double noise, double wander) {
  constexpr double sigmas = 6;          // of a mean of three samples
  constexpr std::size_t countable = 6;  // more of them, and the contact presses no more than the noise
  const double level = std::max(sigmas * noise / std::sqrt(3.0), 2 * wander);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Contact& contact = contacts[c];
    const double end = contact.release.known() ? contact.release.value : force.end();
    const auto runs = low_runs(force, force.index_at(contact.touch.value), force.index_at(end), level);
    if (runs.size() > countable) continue;
    for (const Run& run : runs) {
      const double from = force.time(run.first), to = force.time(run.end);
      if (to - from > longest_dip) continue;
      const double closed = 0.7 * std::min({from - contact.touch.value, end - to, longest_rise});
      const Dip dip = look_at_dip(force, from, to, closed, noise, wander);
      if (!dip.known || dip.opened < sure) continue;
      grazing.push_back({c, contact.touch.value, to, from, dip.opened, false});
      contacts[c].flags |= flag_grazing;
    }
  }
}

}  // namespace powbench::dsp
