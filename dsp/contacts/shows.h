#pragma once

#include <string>
#include <vector>

#include "core/events.h"
#include "dsp/contacts/detect.h"
#include "dsp/filter/force.h"
#include "dsp/options.h"

/// Is it a contact at all? A contact force has one sign, begins and ends at zero, and keeps a level while it stays.

namespace powbench::dsp {

/// A wide-band force without samples' noise: means over three times `detection_width`, and the noise left in them.
struct CalmForce {
  std::vector<double> value;  ///< N, one a sample of the force
  double noise = 0;           ///< N
};
CalmForce calm_force(const Signal&, double noise, const ExtractOptions&);

/// Does the film swing below zero once something has touched, other than in the moment in which a sticking contact
/// breaks? Only then is there vibration to take out: what a contact does while it stays closed is contact force.
/// `first`: contacts by levels.
bool swings_below_zero(const Force&, const std::vector<Interval>& first, double t_end, const ExtractOptions&);

/// Contacts that hardly stand out of the noise, or are no larger than the swings below zero beside them, go.
/// `stripped`: vibration taken out.
void drop_swings(std::vector<Contact>&, const Signal& stripped, double noise, const ExtractOptions&);

/// What the channel shows, with the reason. `vibration`: the impulse below zero is more than `most_below` of that
/// above, or the film swings further below zero than any contact presses.
struct Verdict {
  Shows shows = Shows::nothing;
  std::string reason;
};
Verdict verdict_of(const Force&, const std::vector<Contact>&, double t_end, const ExtractOptions&);

inline constexpr double most_below = 0.5;

}  // namespace powbench::dsp
