#pragma once

#include "sim/models/closing.h"
#include "sim/models/rigid_run.h"

/// The rigid rung behind the specimen and the conditions that `simulate` takes: the second model of a closing.

namespace powbench::sim {

/// The specimen as rigid parts: contacts by the laws that the specimen names, two equal pole faces and stops, fixed
/// contacts on the static core or the housing, which may bend. Without a tilt_inertia the core does not tilt. Where it
/// does, the core's seat is the touch of the pole face on the side of pole 1.
RigidParts rigid_parts(const Specimen&);

/// The events of a trajectory as those of contacts: break A is contact 0, break B the other end of the same bridge, the
/// core's stop the first pole face. Stalls and the switch are left out.
std::vector<RigidEvent> contact_events(std::span<const PlantEvent>);

/// Like `simulate`, by the rigid rung. `ledger`: with the energies as states, held to the tolerance and to their
/// balance (a tenth more time); else the residual is 0. Throws
/// std::invalid_argument for a bad specimen or bad conditions.
Trajectory simulate_rigid(const Specimen&, const Conditions&, double duration, double sample_dt,
                          double relative_tolerance = 1e-8, bool ledger = true, const Supply& bench = {});

/// The same with the magnet's potential from another rung of fields, defined for gaps from 0 on.
Trajectory simulate_rigid_with(const MagneticPotential&, const Specimen&, const Conditions&, double duration,
                               double sample_dt, double relative_tolerance = 1e-8, bool ledger = true,
                               const Supply& bench = {});

}  // namespace powbench::sim
