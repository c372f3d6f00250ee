#include "dsp/events/extract.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/commanded_phase.h"
#include "core/phase.h"
#include "dsp/contacts/contact_train.h"
#include "dsp/contacts/contact_voltage.h"
#include "dsp/contacts/pole.h"
#include "dsp/events/coil.h"
#include "dsp/events/core_seat.h"
#include "dsp/events/doubt.h"
#include "dsp/events/film_paths.h"
#include "dsp/events/lost_time.h"
#include "dsp/events/requested.h"
#include "dsp/filter/event_filter.h"
#include "dsp/filter/force.h"

namespace powbench::dsp {

namespace {

/// s: the coil is switched off, or the record ends.
double closing_end(const Record& record) {
  const double t_end = record.samples() ? record.time(record.samples() - 1) : 0.0;
  const double hold = record.conditions.hold_time;
  return hold > 0 ? std::min(hold, t_end) : t_end;
}

ContactTrain film_train(const Record& record, Channel c, const ExtractOptions& o, std::optional<double> hertz,
                        const Measured& seat, FilmPath& path) {
  path.force = restore_force(record, c, o, hertz);
  const Force& f = path.force;
  if (!f.present) {
    ContactTrain none;
    none.shows = Shows::not_usable;
    none.reason = record.find(c) ? "the channel stays at one value" : "no such channel";
    return none;
  }
  ForceAnalysis found = analyse_force(f, closing_end(record, f.signal), seat, o);
  ContactTrain train = std::move(found.train);
  path.ring = std::move(found.ring), path.stripped = std::move(found.stripped);
  if (o.filter.judged) admit_filter(train, effect_of(o.filter, f.signal.rate()));
  return train;
}

}  // namespace

Events extract_events(const Record& record, const ExtractOptions& o, const RunBoth& both) {
  FilmPaths unused;
  return extract_events(record, o, both, unused);
}

Events extract_events(const Record& record, const ExtractOptions& o, const RunBoth& both, FilmPaths& paths) {
  check(o);
  if (o.filter.wanted() && !o.filter.judged) {
    Extracted e = extract_on_request(record, o);
    paths = std::move(e.bare);
    return std::move(e.events);
  }
  Events e;
  e.method = (o.filter.judged ? name_of(o.filter) : std::string("wide-band")) + " force, ring and pulse fit";
  e.parameters_hash = parameters_hash(o);
  const auto supply = supply_fit(record, o);
  const std::optional<double> hertz = supply ? std::optional(supply->hertz) : std::nullopt;
  e.coil = coil_events(record, supply, o);
  e.core = core_events(record, o);
  both([&] { e.pvdf_a = film_train(record, Channel::pvdf_a, o, hertz, e.core.seat, paths.a); },
       [&] { e.pvdf_b = film_train(record, Channel::pvdf_b, o, hertz, e.core.seat, paths.b); });
  e.contact_voltage = contact_voltage_train(record, o);

  cross_check(e.contact_voltage, e.pvdf_a, e.pvdf_b, closing_end(record));
  if (record.calibration.empty()) e.flags |= flag_no_calibration;
  conclude(e, record, o);
  return e;
}

void check_angle(Events& e, const Conditions& c, double tolerance) {
  for (std::uint32_t* flags : {&e.coil.flags, &e.flags})
    *flags &= ~static_cast<std::uint32_t>(flag_angle_off);
  const double commanded = commanded_phase(c);
  if (!(tolerance > 0) || !std::isfinite(commanded) || !e.coil.closing_angle.known()) return;
  if (std::abs(wrap_half_turn(e.coil.closing_angle.value - commanded)) <= tolerance) return;
  for (std::uint32_t* flags : {&e.coil.flags, &e.flags}) *flags |= flag_angle_off;
}

void conclude(Events& e, const Record& record, const ExtractOptions& o) {
  admit_doubt(e, record);  // first: what follows is made of the trains' times and must not outlive them
  for (ContactTrain* t : {&e.pvdf_a, &e.pvdf_b})
    for (Contact& c : t->contacts)
      if ((c.flags & flag_clipped) != 0 && (c.flags & flag_poor_fit) != 0)
        c.peak = {};  // no shape tells what was cut off
  e.pole.by_force = pole_by_force(e.pvdf_a, e.pvdf_b, o.merge_openings);
  const Disagreement d = disagreement(e.pole.by_force, e.contact_voltage, closing_end(record));
  e.pole.disagreement = d.total;
  e.pole.longest_disagreement = d.longest;
  const double end = closing_end(record);
  const bool moves = core_moves(record, end);
  const std::array trains{std::pair(&e.pvdf_a, std::pair(Channel::pvdf_a, Channel::pvdf_a)),
                          std::pair(&e.pvdf_b, std::pair(Channel::pvdf_b, Channel::pvdf_b)),
                          std::pair(&e.contact_voltage, std::pair(Channel::contact_a, Channel::contact_a)),
                          std::pair(&e.pole.by_force, std::pair(Channel::pvdf_a, Channel::pvdf_b))};
  for (const auto& [t, from] : trains) {
    split_trains(*t, e.core.seat);
    doubt_settled(
        *t,
        {end, std::min(unbroken_end(*t, record, from.first, end), unbroken_end(*t, record, from.second, end)),
         moves});
  }
  for (const std::uint32_t f :
       {e.pvdf_a.flags, e.pvdf_b.flags, e.contact_voltage.flags, e.core.flags, e.coil.flags})
    e.flags |= f;
}

}  // namespace powbench::dsp
