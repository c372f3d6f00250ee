#pragma once

#include "core/events.h"
#include "dsp/signal/signal.h"

namespace powbench::dsp {

/// Largest (side +1) or smallest (-1) force between two times, from a polynomial through it; N. The part used shrinks
/// until the polynomial fits; the last change of the value counts as uncertainty. Not known with fewer than six good
/// samples.
Measured locate_extreme(const Signal& force, double from, double to, int side, double noise);

}  // namespace powbench::dsp
