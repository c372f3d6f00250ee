#pragma once

#include <limits>

#include "core/record.h"
#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// When a signal that rests at its beginning and, on the same level, at its end leaves what it did in between: s on the
/// signal's own time axis. A sine of mains frequency: where it departs from the sine fitted to it, by a fifth of its
/// amplitude over 0.3 ms. A level, a ripple or a pulsation: the last sample within a tenth of the largest of the 25 ms
/// before it; a pulsation from there on until it has fallen to a tenth. NaN: no rest at its beginning (the first
/// hundredth) or at its end (3 ms, behind a pulsation 11 ms, as its pauses are as quiet), or rests on two levels.
double left_at(const Signal&);

/// When the coil was switched off, s after switch-on: `left_at` of the coil voltage, without that channel of the coil
/// current; NaN where it shows no end. An AC coil behind a solid-state switch is on until its current is zero. By the
/// current it is up to a quarter of a mains period early; a current that a diode keeps flowing is off where it begins
/// to fall.
double seen_switch_off(const Record&);

/// When contact voltage, a film or the travel, whichever is first, comes back to where it was before switch-on, s after
/// it; NaN where none does.
struct SeenReturn {
  double at = std::numeric_limits<double>::quiet_NaN();
  Channel channel = Channel::contact_a;
};
SeenReturn seen_return(const Record&);

}  // namespace powbench::dsp
