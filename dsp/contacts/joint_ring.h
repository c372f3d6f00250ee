#pragma once

#include "dsp/contacts/joint_fit.h"

/// What belongs to the ring of a joint model and what to its contacts: modes added, pieces of ring that stood for
/// contacts dropped.

namespace powbench::dsp {

/// Modes larger than any vibration can be cancel each other where they are seen and say nothing elsewhere. `limit`: N,
/// at the onset.
bool bounded(const Ring&, double limit);

/// One more mode while what is left of the model's own samples shows one that is worth its four parameters.
void add_modes(const JointInput&, JointModel&, double limit);

/// A ring that is not known yet: the strongest oscillation in what the contacts leave, its start tried every 0.2 ms
/// from `from` to `to`. False when there is none.
bool seed_ring(const JointInput&, JointModel&, double from, double to);

/// A piece of ring before the onset looks like a contact, and the other way round: a pulse next to the onset goes
/// when the fit without it, its time open to the onset, explains as much. So does one no longer than a swing of the
/// ring and no larger than it, from 2 ms before the onset on, when the fit without it explains more.
void drop_stand_ins(const JointInput&, JointModel&);

/// The same after the core was seen to land: vibration that its own model did not reach yet crosses the levels as a
/// small contact, and a fit with that contact keeps the vibration wrong. A pulse smaller than the ring where it lies
/// stays only where it earns its parameters.
void drop_ring_pieces(const JointInput&, JointModel&);

/// A mode outside the band or more damped than the options allow is a contact's own motion: such modes go, and what is
/// left is fitted again. No ring where none stays.
void keep_within_limits(const JointInput&, JointModel&);

}  // namespace powbench::dsp
