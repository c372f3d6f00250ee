#include "dsp/events/doubt.h"

#include <algorithm>
#include <cmath>

namespace powbench::dsp {

namespace {

struct Span {
  double first = 0, last = 0;
  bool holds(double t) const { return t >= first && t <= last; }
};

bool vague(const Measured& m) {
  return m.known() && !(std::isfinite(m.u) && m.u >= 0);
}

void admit(Measured& time, double coarse, std::uint32_t& flags) {
  if (!vague(time)) return;
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

void admit(ContactTrain& t, const Span& span) {
  const double coarse = std::max(t.resolution, 1e-6);
  const std::size_t before = t.contacts.size();
  std::erase_if(t.contacts, [&](const Contact& c) { return c.touch.known() && !span.holds(c.touch.value); });
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
  if (t.contacts.size() != before) t.bounce_count = std::max<int>(0, static_cast<int>(t.contacts.size()) - 1);
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

void doubt_settled(ContactTrain& t, double t_end) {
  constexpr double longer = 1.5;
  if (!t.settled.known()) return;
  double longest = 0;
  for (const Contact& c : t.contacts)
    if (c.release.known() && c.touch.known()) longest = std::max(longest, c.release.value - c.touch.value);
  if (t_end - t.settled.value >= longer * longest) return;
  t.settled = t.bounce_time = {};
  t.flags |= flag_chatter;
}

void admit_doubt(Events& e, const Record& record) {
  if (record.samples() == 0) return;
  double delay = 0;  // events stand on the channels' own, earlier time axes
  for (const ChannelRecord& c : record.channels) delay = std::max(delay, std::abs(c.delay));
  const double tick = 1 / record.sample_rate;
  const Span span{record.time(0) - delay - tick, record.time(record.samples() - 1) + delay + tick};
  for (ContactTrain* t : {&e.pvdf_a, &e.pvdf_b, &e.contact_voltage}) {
    admit(*t, span);
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
