#pragma once

#include <string>

#include "sim/specimen/specimen.h"

/// What the contact numbers of a specimen stand for. Each contact is between two bodies: its damping comes from their
/// effective mass mu = m1 m2 / (m1 + m2), as free bodies for the fraction of a millisecond that an impact lasts.
///
/// | contact | bodies                                        | number                                        |
/// | pad     | one bridge, what carries the fixed contacts   | restitution                                   |
/// | stop    | core, static core                             | restitution                                   |
/// | seat    | one bridge, core                              | damping ratio z, c = 2 z sqrt(k mu)           |
///
/// A restitution e is what a drop test shows: speed of separation over speed of approach. With exponent 1 the force is
/// F = max(0, k d + c d'), and e = rebound_ratio(c / (2 sqrt(k mu))) at any speed. With another exponent n it is Hunt
/// and Crossley's F = k d0 (d / d0)^n (1 + lambda d'), and e holds at the speed of the specimen.

namespace powbench::sim {

double pad_mass(const Specimen&);   ///< mu, kg
double stop_mass(const Specimen&);  ///< mu, kg
double seat_mass(const Specimen&);  ///< mu, kg

double pad_damping(const Specimen&);   ///< c for exponent 1, both breaks of one bridge, N s/m
double stop_damping(const Specimen&);  ///< c for exponent 1, N s/m
double seat_damping(const Specimen&);  ///< c, N s/m

/// Depth at which the stop carries the return spring's preload with the contactor open, m.
double stop_rest_depth(const Specimen&);

/// What of a specimen only the rigid rung knows, in one sentence with the key and what to take instead; empty: nothing.
std::string rigid_only(const Specimen&);

/// A specimen whose restitutions and seat damping have the meaning of files before version 0.1: restitutions of the
/// damping ratio -ln e / sqrt(pi^2 + ln^2 e) (0 gave 1) at the full mass of core and bridge. The result moves as
/// those did.
Specimen with_rebounds(Specimen);

}  // namespace powbench::sim
