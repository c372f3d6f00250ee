#pragma once

#include "dsp/contacts/detect_round.h"
#include "dsp/contacts/joint_fit.h"
#include "dsp/filter/force.h"
#include "dsp/options.h"

/// Core vibration and contacts told apart without a reference.

namespace powbench::dsp {

struct Separated {
  JointModel model;
  Round round;             ///< contacts crossed on the stripped force, the start of `model`
  double from = 0.0;       ///< s: start of the samples used
  bool found = false;      ///< there is a ring
  bool open_time = false;  ///< the ring explains all open time; contacts were left out
  bool whole = false;      ///< the model holds all contacts, not only those after the core landed
};

/// Is the force better without the ring that was found? `noise`: N, one sample.
bool worth_stripping(const Separated&, double noise);

/// The explanation leaves nothing to ask: its sum of squares is what noise gives, and every contact is modelled.
bool convincing(const Separated&);

/// The whole record explained without any ring: all contacts of `first` in one joint fit.
Separated without_ring(const Force&, const Round& first, double t_end, const ExtractOptions&);

/// From the end backwards: the ring is first identified where the contact stays closed, then carried back in steps of
/// 1.5 ms, so that it is never extrapolated far. In each step contacts are detected on the stripped force and fitted
/// together with the ring; once the ring's onset lies well inside the window, the rest of the record is free of it. A
/// ring that died before the contact settled is looked for in what the contacts of each step leave. `first`: contacts
/// before anything is taken out. `core_seat`: s; when known the ring starts within five standard uncertainties of it.
Separated separate_ring(const Force&, const Round& first, const Measured& core_seat, double t_end,
                        const ExtractOptions&);

/// Vibration that only the contact at rest shows, its film never swings below zero: taken where its modes explain the
/// whole record to the noise, and more of it than a ring that starts at rest. `first`: as above; `bare`: of
/// `without_ring`, nothing is looked for where it is convincing.
Separated separate_at_rest(const Force&, const Round& first, const Separated& bare, double t_end,
                           const ExtractOptions&);

}  // namespace powbench::dsp
