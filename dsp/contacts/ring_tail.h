#pragma once

#include "dsp/contacts/detect_round.h"
#include "dsp/filter/force.h"
#include "dsp/options.h"
#include "dsp/vibration/ring.h"

/// The modes of a ring where the contact stays closed and only ring and a smooth force exist.

namespace powbench::dsp {

/// First identification. A contact of metal goes on moving for up to a millisecond after its last touch; where that
/// shows, the tail begins later. Nothing where the last contact opens again.
Ring ring_from_tail(const Force&, const Round&, double t_end, const ExtractOptions&);

/// What the contact at rest shows (`joint_rest` s after the last touch, `touch`): modes to a few hertz, but not those
/// that have died by then. Its onset is not looked for.
Ring ring_at_rest(const Force&, double touch, double t_end, const ExtractOptions&);

/// The strongest mode of `ring` at its onset is one of those of `other`, to a tenth.
bool same_vibration(const Ring& ring, const Ring& other);

}  // namespace powbench::dsp
