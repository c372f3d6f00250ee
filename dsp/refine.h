#pragma once

#include <vector>

#include "core/events.h"
#include "dsp/options.h"
#include "dsp/signal.h"

namespace powbench::dsp {

/// Touch, release and peak of each contact from the force next to them (`locate_edge`, `locate_peak`). The shape that found a contact
/// says roughly where to look; what it cannot follow no longer moves the times. A contact whose edges run into each
/// other keeps what it had and carries flag_poor_fit. `force`: vibration taken out; `noise`: N, one sample of it.
void refine_contacts(std::vector<Contact>&, const Signal& force, double noise, const ExtractOptions&);

}  // namespace powbench::dsp
