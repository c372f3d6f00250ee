#pragma once

#include <utility>
#include <vector>

#include "core/events.h"
#include "dsp/filter/force.h"
#include "dsp/options.h"
#include "dsp/vibration/ring.h"

/// From the restored force of one film to its train of contacts.

namespace powbench::dsp {

struct ForceAnalysis {
  ContactTrain train;
  Ring ring;        ///< core vibration found on this channel; empty when none stands out
  Signal stripped;  ///< N: restored force minus `ring`
};

/// Alternates between contacts (given the ring) and ring (given the contacts). `core_seat`: s, when the laser
/// or the reference saw it; the ring then starts within five standard uncertainties of it. `t_end`: s, end of the
/// closing.
ForceAnalysis analyse_force(const Force&, double t_end, const Measured& core_seat, const ExtractOptions&);

/// Settled, bounce time and count from the contacts; openings up to `merge` are closed first (0 = none).
void summarise(ContactTrain&, double merge);

}  // namespace powbench::dsp
