#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/events.h"
#include "dsp/contacts/crest.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"
#include "dsp/vibration/ring.h"

namespace powbench::dsp {

/// A dip in which the force only just reaches zero: where the contact opened in it, it settles at `after`, else at
/// `before`; s.
struct Grazing {
  std::size_t contact = 0;  ///< index of the one before
  double before = 0, after = 0;
  double release = 0;   ///< s, into the dip
  double opened = 0.5;  ///< probability that it opened
  bool listed = false;  ///< as an opening

  /// Standard deviation of a time that is one of two from the one taken, over their distance; a third at least.
  double share() const { return std::max(std::sqrt(listed ? 1 - opened : opened), 1 / 3.0); }
};

/// Force of a film as the edges are dated on it.
struct EdgeForce {
  const Signal& signal;                      ///< N, vibration taken out
  double noise = 0;                          ///< N, one sample, with the vibration that is left
  double white = 0;                          ///< N, without
  double delay = 0;                          ///< s, of the amplifier
  double wander = 0;                         ///< N: error of the zero in an opening
  const VibratingFilm* vibrating = nullptr;  ///< where vibration is known to be, and not all of it explained
};

/// Touch, release and peak of each contact from the force next to them (`locate_edge`, `locate_peak`). The shape that
/// found a contact says roughly where to look; what it cannot follow no longer moves the times. All touches have one
/// law (`agree_on_law`). A contact whose edges run into each other keeps what it had and carries flag_poor_fit.
/// Vibration that is left is no white noise: what of it swings below zero goes into u as the time the force needs to
/// rise so far; on a vibrating film an edge is what `look_at_edge` makes of it. Dips of which nobody can say whether
/// they are openings are returned, and their contacts carry flag_grazing.
std::vector<Grazing> refine_contacts(std::vector<Contact>&, const EdgeForce&, const ExtractOptions&);

/// s from an edge inwards (`side` +1: later) until the force, vibration taken out, stands above `amplitude` (N) for
/// good, at most 0.5 ms: a vibration of that amplitude, were all of it still there, could hide no more of the edge.
double hidden_by_vibration(const EdgeForce&, double edge, int side, double amplitude, const ExtractOptions&);

/// A vibration that was taken out without explaining the record to its noise may have moved edges behind its onset.
/// The force as it came, `unaided`, dates them differently, which counts as far as the vibration could hide the edge
/// (as `hidden_by_vibration`); and what may be left of the vibration (a seventh, or as far as the stripped force still
/// swings below zero) may hide the rise up to there. Both, over sqrt(3), go into u; peaks take on what may be left.
void doubt_stripping(std::vector<Contact>&, const Signal& unaided, const EdgeForce& stripped, const Ring&,
                     const ExtractOptions&);

}  // namespace powbench::dsp
