#pragma once

#include "core/events.h"
#include "dsp/contacts/shows.h"
#include "dsp/signal/signal.h"

/// Vibration that no model took out, or that was never looked for, beside an edge. Only its amplitude is known, from
/// where the film shows it alone; what follows for the edge is said here.

namespace powbench::dsp {

/// N: amplitude that the vibration of a contact that stays closed had at its last touch, `touch`: from the force at
/// rest 2.5 .. 5 and 5 .. 10 ms after it, where what a contact does of its own is over, carried back by the ratio of
/// the two. 0 where the later one does not stand out of the noise four times, or the record ends before.
double vibration_at_rest(const CalmForce&, const Signal& force, double touch, double t_end);

/// A film that vibrates.
struct VibratingFilm {
  const Signal& unaided;  ///< N, the force as it came
  CalmForce calm;         ///< of `unaided`
  double at_rest = 0;     ///< N, of `vibration_at_rest`
  double last = 0;        ///< s, the touch that it belongs to
};

/// One edge as it was found in the calm force `left` of the film `force`, vibration taken out as far as it could be.
struct FoundEdge {
  double time = 0;   ///< s
  int side = +1;     ///< +1 touch, -1 release
  double reach = 0;  ///< s inwards that belong to the contact
  double open = 0;   ///< s outwards until another contact
};

/// How vibration moves an edge. `passed`, s: it lies so much further inwards. Vibration that is on its way up looks
/// like the foot of a contact, but comes back down: where the force, before it rises beyond twice the amplitude, falls
/// again to half of a crest (to 0.3 of it before a release, where a pad may do so itself), the edge is the last such
/// dip. 0 where it does not. `hidden`, s: vibration of that amplitude may hide so much of the edge: the time in which
/// the force rises above it for good and, where the film swings below zero just outside, from there on. 0 where open
/// time beside the edge is calm. `beyond`: s inwards to the touch that the rise from two to four amplitudes points to,
/// with its uncertainty; what losses do before a release follows no power.
struct EdgeInVibration {
  double passed = 0, hidden = 0;
  Measured beyond;
  /// The edge that was dated as `found`, vibration considered. Without `beyond`: moved by `passed`, with that a third
  /// of the way off (on the tuning seeds one dip of nine is the contact's own) and anywhere in what is hidden. With
  /// it, where the vibration leaves the edge uncertain by more than 20 us: the mean of the two by their certainty;
  /// half of what they differ is in u.
  Measured of(const Measured& found, int side) const;
};
EdgeInVibration look_at_edge(const VibratingFilm&, const Signal& force, const CalmForce& left,
                             const FoundEdge&);

/// s from `edge` inwards until the calm force stands at `level` for good: the last time below it before it comes to
/// twice that; no further than 0.5 ms. A crest of the vibration passes the level and comes back.
double time_to(const CalmForce&, const Signal& force, double edge, int side, double level);

/// N: how far the calm force swings below zero between two times; 0 where no swing stands out of the noise.
double swing_below(const CalmForce&, const Signal& force, double from, double to);

}  // namespace powbench::dsp
