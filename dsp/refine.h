#pragma once

#include <vector>

#include "core/events.h"
#include "dsp/options.h"
#include "dsp/signal.h"

namespace powbench::dsp {

/// A dip in which the force only just reaches zero: with it the contact before settles at `after`, without it at `before`; s.
struct Grazing {
  double before = 0, after = 0;
};

/// Touch, release and peak of each contact from the force next to them (`locate_edge`, `locate_peak`). The shape that found a contact
/// says roughly where to look; what it cannot follow no longer moves the times. A contact whose edges run into each
/// other keeps what it had and carries flag_poor_fit. `force`: vibration taken out; `noise`: N, one sample of it.
/// Dips of which nobody can say whether they are openings are returned, and their contacts carry flag_grazing.
std::vector<Grazing> refine_contacts(std::vector<Contact>&, const Signal& force, double noise,
                                     const ExtractOptions&);

/// A vibration that was taken out without explaining the record to its noise may have moved edges behind its onset. Each takes on as
/// uncertainty how far the force as it came, `unaided`, dates it differently, over sqrt(3).
void doubt_stripping(std::vector<Contact>&, const Signal& unaided, const Signal& stripped, double onset,
                     double noise, const ExtractOptions&);

}  // namespace powbench::dsp
