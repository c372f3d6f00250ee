#pragma once

#include "sim/mechanics/rigid_parts.h"

/// The rigid contactor that integrators are compared on.

namespace powbench::bench {

/// The closing that the speed of integrators is judged by: 17 degrees of freedom, three main and two auxiliary
/// bridges of slightly different gaps, four base modes of 0.8 .. 4.8 kHz, 24 contacts with Hunt-Crossley damping,
/// k = 1e8 (pole faces 1e9) times `stiffness`.
sim::RigidParts reference_closing(double stiffness = 1, double damping = 1);

/// The same parts without any loss: no damping in contacts, springs and modes, no friction.
sim::RigidParts without_losses(sim::RigidParts);

}  // namespace powbench::bench
