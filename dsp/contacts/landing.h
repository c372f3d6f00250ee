#pragma once

#include <functional>
#include <vector>

#include "core/events.h"
#include "dsp/contacts/detect.h"

namespace powbench::dsp {

inline constexpr double landing_time =
    0.3e-3;  ///< s after the first impact in which a core may strike again and change the ring

/// Around the core's seat, from three standard uncertainties before it to `landing_time` after it, the ring is still
/// being made and no model takes it out. There
/// - a contact whose peak is below `amplitude` (N, the ring at its onset) is not told from the blow itself: it goes;
/// - a touch or release keeps its time from the stripped force, but its uncertainty reaches to where the force as it
///   came, `unaided`, shows it: their distance over sqrt(12) (`landing_time` where only one of them sees it), with
///   flag_ring_overlap. `hidden`, s, of a time and a side (+1 touch, -1 release): so much of an edge a vibration of
///   the amplitude can hide; no more of the distance counts (without it all of it). This is an estimate from two
///   sightings, no bound: what both share, such as a part of the blow that the model missed and that looks like a
///   contact still closed, it does not show.
/// True when there was anything of the kind: the train then carries flag_ring_overlap too.
bool doubt_landing(std::vector<Contact>&, const std::vector<Interval>& unaided, const Measured& seat,
                   double amplitude, const std::function<double(double, int)>& hidden = {});

}  // namespace powbench::dsp
