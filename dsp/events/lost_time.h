#pragma once

#include "core/events.h"
#include "core/record.h"

namespace powbench::dsp {

/// What samples that were not recorded leave open in the train of a channel. An edge in such a stretch of length L has
/// at least the uncertainty L / sqrt(12). A stretch longer than the channel resolves may hide more: an opening, where
/// the contact is closed on both sides of it, or a whole contact, where it lies within `near_touch` before the first
/// touch, whose uncertainty then reaches back to it. Each raises flag_gap on the contact and the train.
void admit_lost_time(ContactTrain&, const Record&, Channel);
inline constexpr double near_touch = 5e-3;  ///< s

/// The end of what is seen without a break behind the last touch, s: the start of the first stretch that may hide an
/// opening, else `t_end`.
double unbroken_end(const ContactTrain&, const Record&, Channel, double t_end);

}  // namespace powbench::dsp
