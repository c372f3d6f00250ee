#pragma once

#include "core/events.h"
#include "core/record.h"

namespace powbench::dsp {

/// What a fit could not tell must not look like a measurement. In every train: a time without a finite uncertainty
/// gets that of the coarse crossing (the train's resolution) and flag_poor_fit; a release outside the record becomes
/// unknown, a contact whose touch lies outside goes; force and impulse without a finite uncertainty become unknown. A
/// settled force below 0.05 N or above 200 N, or films that settle a factor of 5 apart, raise flag_gain. Sums
/// (settled, bounce time, bounce count) follow. extract_events and conclude call it: their callers need not.
void admit_doubt(Events&, const Record&);

/// A contact that stays closed at the end of what is seen, `t_end` in s, may only be between two openings. Settled
/// and bounce time are unknown, with flag_chatter, where it has been closed for less than 1.5 times as long as it was
/// closed before an earlier opening.
void doubt_settled(ContactTrain&, double t_end);

}  // namespace powbench::dsp
