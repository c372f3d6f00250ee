#include "dsp/events/doubt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "dsp/events/lost_time.h"
#include "dsp/signal/signal.h"
#include "dsp/signal/statistics.h"

namespace powbench::dsp {

namespace {

struct Span {
  double first = 0, last = 0;
  bool holds(double t) const { return t >= first && t <= last; }
};

constexpr double most_u = 10e-3;  // s: half a period of the mains, more than any bounce

bool vague(const Measured& m) {
  return m.known() && !(std::isfinite(m.u) && m.u >= 0);
}

/// A time that is less certain than that is none of a fit.
bool vague_time(const Measured& m) {
  return vague(m) || (m.known() && m.u > most_u);
}

/// Shorter than the film resolves, and of so few samples, or of edges less certain than it is long, that it has no
/// shape.
bool spike(const Contact& c, double resolution, double tick) {
  constexpr double few = 5, share = 0.6;
  if (!c.touch.known() || !c.release.known()) return false;
  const double length = c.release.value - c.touch.value;
  if (length < std::min(few * tick, share * resolution)) return true;
  return length < resolution && (!(c.touch.u < length) || !(c.release.u < length));
}

void admit(Measured& time, double coarse, std::uint32_t& flags) {
  if (!vague_time(time)) return;
  time.u = coarse;
  flags |= flag_poor_fit;
}

void admit(Contact& c, double coarse, const Span& span) {
  admit(c.touch, coarse, c.flags);
  admit(c.release, coarse, c.flags);
  if (c.release.known() && (!span.holds(c.release.value) || c.release.value < c.touch.value)) {
    c.release = {};
    c.flags |= flag_edge;
  }
  for (Measured* m : {&c.peak, &c.impulse})
    if (vague(*m)) *m = {};
}

/// `tick`: s, of a film; a voltage's closure may be as short as a sample. `switched_on`: the coil's channels show that
/// it is switched on at time 0, so what has ended before is none of this closing.
void admit(ContactTrain& t, const Span& span, std::optional<double> tick, bool switched_on) {
  const double coarse = std::max(t.resolution, 1e-6);
  const std::size_t before = t.contacts.size();
  std::erase_if(t.contacts, [&](const Contact& c) { return c.touch.known() && !span.holds(c.touch.value); });
  if (switched_on)
    std::erase_if(t.contacts, [](const Contact& c) { return c.release.known() && c.release.value < 0; });
  if (tick && std::erase_if(t.contacts, [&](const Contact& c) { return spike(c, t.resolution, *tick); }) > 0)
    t.flags |= flag_resolution;
  for (Contact& c : t.contacts) admit(c, coarse, span);
  // only the last contact may stay closed
  for (std::size_t i = 0; i + 1 < t.contacts.size(); ++i)
    if (!t.contacts[i].release.known()) {
      t.contacts[i].release = {t.contacts[i + 1].touch.value, coarse};
      t.contacts[i].flags |= flag_poor_fit;
    }
  admit(t.settled, coarse, t.flags);
  if (t.settled.known() && !span.holds(t.settled.value)) t.settled = {};
  if (vague(t.settled_force)) t.settled_force = {};
  if (vague(t.bounce_time) || !t.settled.known()) t.bounce_time = {};
  if (t.contacts.size() == before) return;
  t.bounce_count = std::max<int>(0, static_cast<int>(t.contacts.size()) - 1);
  if (!t.bounce_time.known()) return;
  const Measured& first = t.contacts.front().touch;
  t.bounce_time = t.contacts.size() == 1
                      ? Measured{0.0, 0.0}
                      : Measured{t.settled.value - first.value, std::hypot(t.settled.u, first.u)};
}

/// Nothing closes by itself before the coil is switched on.
void admit_beginning(ContactTrain& t) {
  constexpr double early = 0.1e-3;  // s
  if (t.contacts.empty() || !t.contacts.front().touch.known()) return;
  const Measured& first = t.contacts.front().touch;
  if (first.value < -std::max(early, 3 * first.u)) t.flags |= flag_switch_on;
}

constexpr double least_settled = 0.05, most_settled = 200;  // N, of one break of a contactor
constexpr double unlike = 5;                                // ratio of the two breaks' settled forces

/// A gain wrong by ten shows in the settled force, which springs fix within a factor of a few.
void check_gains(ContactTrain& a, ContactTrain& b) {
  for (ContactTrain* t : {&a, &b}) {
    const double f = t->settled_force.value;
    if (t->present && t->settled_force.known() && f != 0 && !(f >= least_settled && f <= most_settled))
      t->flags |= flag_gain;
  }
  const double fa = a.settled_force.value, fb = b.settled_force.value;
  if (!a.present || !b.present || !(fa > 0) || !(fb > 0)) return;
  if (std::max(fa, fb) > unlike * std::min(fa, fb)) a.flags |= flag_gain, b.flags |= flag_gain;
}

}  // namespace

void doubt_settled(ContactTrain& t, const Seen& seen) {
  constexpr double longer = 1.5;
  if (!t.settled.known()) return;
  double wanted = least_closed;
  for (const Contact& c : t.contacts)
    if (c.release.known() && c.touch.known())
      wanted = std::max(wanted, longer * (c.release.value - c.touch.value));
  const bool long_enough = seen.end - t.settled.value >= wanted;
  if (long_enough && !seen.core_moves && seen.unbroken - t.settled.value >= wanted) return;
  t.settled = t.bounce_time = {};
  t.flags |= long_enough && !seen.core_moves ? flag_gap : flag_chatter;
}

bool core_moves(const Record& record, double end) {
  constexpr double window = 0.2e-3, share = 0.01, clear = 6;
  const Signal s = to_signal(record, Channel::laser);
  if (s.empty()) return false;
  const std::size_t quiet = s.index_at(0.0), last = s.index_at(end);
  const auto n = static_cast<std::size_t>(window / 2 / s.dt);
  if (quiet < 10 || n < 2 || last < quiet + 2 * n) return false;
  const auto part = [&](std::size_t from, std::size_t count) {
    return std::span(s.value).subspan(from, count);
  };
  const double noise = robust_sigma(part(0, quiet));
  const auto [low, high] = std::minmax_element(s.value.begin(), s.value.begin() + std::ptrdiff_t(last));
  const double moved = std::abs(median(part(last - n, n)) - median(part(last - 2 * n, n)));
  // medians of two halves of the window are half of it apart
  return moved > std::max(clear * noise, 0.5 * share * (*high - *low));
}

void admit_doubt(Events& e, const Record& record) {
  if (record.samples() == 0) return;
  double delay = 0;  // events stand on the channels' own, earlier time axes
  for (const ChannelRecord& c : record.channels) delay = std::max(delay, std::abs(c.delay));
  const double tick = 1 / record.sample_rate;
  const Span span{record.time(0) - delay - tick, record.time(record.samples() - 1) + delay + tick};
  const std::array trains{std::pair(&e.pvdf_a, Channel::pvdf_a), std::pair(&e.pvdf_b, Channel::pvdf_b),
                          std::pair(&e.contact_voltage, Channel::contact_a)};
  for (const auto& [t, channel] : trains) {
    admit(*t, span, channel == Channel::contact_a ? std::nullopt : std::optional(tick),
          e.coil.switch_on.known());
    admit_lost_time(*t, record, channel);
    admit_beginning(*t);
    e.flags |= t->flags;
  }
  check_gains(e.pvdf_a, e.pvdf_b);
  e.flags |= (e.pvdf_a.flags | e.pvdf_b.flags) & flag_gain;
  for (Measured* m : {&e.core.seat, &e.core.settled, &e.core.bounce_time, &e.core.impact_velocity,
                      &e.core.travel, &e.coil.closing_angle, &e.coil.switch_on, &e.coil.mains_hertz,
                      &e.coil.supply_volts, &e.coil.peak_current})
    if (vague(*m)) *m = {};
}

}  // namespace powbench::dsp
