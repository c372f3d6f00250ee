#pragma once

#include "core/record.h"

namespace powbench::dsp {

/// When the coil's voltage, or without that channel its current, really begins, s after time 0, to a few ms, where the
/// record contradicts that it is time 0: over the 4 ms that end 1 ms before time 0 it swings by a twentieth of its
/// largest swing, or it is still at rest 4 ms behind, or the record begins at time 0 with a third of the current's
/// largest mean. A channel of noise, whose neighbours are as far apart as its values, says nothing. NaN: no
/// contradiction. -infinity: before the record begins.
double contradicted_switch_on(const Record&);

}  // namespace powbench::dsp
