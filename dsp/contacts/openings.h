#pragma once

#include <vector>

#include "core/events.h"
#include "dsp/contacts/crest.h"
#include "dsp/contacts/refine.h"
#include "dsp/signal/signal.h"

/// Is a dip of the force between two contacts, or within one, an opening?

namespace powbench::dsp {

/// s from a touch to its first maximum, or from the last one to its release.
inline constexpr double longest_rise = 1.5e-3;

/// An opening shows no force. What the levels took for one is looked at again: one smooth indentation through both
/// edges says how probable it is that the contact opened; with less than one half (0.3 in loud noise) it is not listed.
/// Where none explains the force, a least force that stands clear of zero makes the two contacts one. `noise`: N, of a
/// sample; `vibration`: N, its amplitude where it is known to be there, else 0; `wander`: N, error of the zero;
/// `still`: the film shows no vibration, so a stretch at zero between steep flanks is an opening whatever the
/// indentation says.
std::vector<Grazing> close_dips(std::vector<Contact>&, const CalmForce& quiet, const Signal& force,
                                double noise, double vibration, double wander, bool still);

/// An opening shorter than the levels resolve is not listed, and what it would change is in u: a dip to zero within a
/// contact that may be an opening joins `grazing`, and its contact carries flag_grazing.
void doubt_dips(std::vector<Contact>&, std::vector<Grazing>& grazing, const Signal& force, double noise,
                double wander);

}  // namespace powbench::dsp
