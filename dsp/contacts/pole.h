#pragma once

#include "core/events.h"

/// One pole from its two breaks, and a train from what happened before and after the core's impact.

namespace powbench::dsp {

/// Closed while both are: touches are the later, releases the earlier of the two, each with its own uncertainty; the
/// openings of the pole are those of either break. Not present unless both are.
ContactTrain pole_by_force(const ContactTrain& a, const ContactTrain& b, double merge);

/// Total time and longest stretch in [0, t_end] in which exactly one of the trains is closed, with the uncertainty of
/// the edges. Unknown unless both are present.
struct Disagreement {
  Measured total, longest;
};
Disagreement disagreement(const ContactTrain&, const ContactTrain&, double t_end);

/// Fills first_train and second_train: an opening belongs to the second when it begins no earlier than the seat, less
/// three standard uncertainties and 20 us (the frame carries the impact to the contacts while the core still yields).
void split_trains(ContactTrain&, const Measured& seat);

}  // namespace powbench::dsp
