#pragma once

#include "core/events.h"
#include "core/record.h"

namespace powbench::dsp {

/// What a fit could not tell must not look like a measurement. In every train: a time without a finite uncertainty
/// below 10 ms gets that of the coarse crossing (the train's resolution) and flag_poor_fit; a release outside the
/// record becomes unknown, a contact whose touch lies outside goes; force and impulse without a finite uncertainty
/// become unknown. What is a spike, or has ended before the coil was seen to be switched on, is no contact of the
/// closing. A settled force below 0.05 N or above 200 N, or films that settle a factor of 5 apart, raise flag_gain.
/// Sums (settled, bounce time, bounce count) follow. extract_events and conclude call it: their callers need not.
void admit_doubt(Events&, const Record&);

/// Where the closing is seen to end, s.
struct Seen {
  double end = 0;           ///< the coil is switched off, or the record ends
  double unbroken = 0;      ///< the same, or the start of lost samples that may hide an opening
  bool core_moves = false;  ///< the moving core has not come to rest at `end`
};

/// A contact that stays closed at the end of what is seen may only be between two openings. Settled and bounce time
/// are unknown where it has been closed for less than `least_closed`, or than 1.5 times as long as it was closed before
/// an earlier opening, and where the core still moves: with flag_gap where lost samples are why, else with
/// flag_chatter.
void doubt_settled(ContactTrain&, const Seen&);
inline constexpr double least_closed = 3e-3;  ///< s

/// True where the laser shows the core moving by more than a hundredth of its travel in the last 0.2 ms before `end`.
bool core_moves(const Record&, double end);

}  // namespace powbench::dsp
