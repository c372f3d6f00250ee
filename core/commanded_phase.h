#pragma once

#include "core/conditions.h"
#include "core/units.h"

namespace powbench {

/// The phase of the coil voltage at which a closing was asked to begin, rad: the closing angle, and half a turn more
/// for negative polarity. Not wrapped: [0, 3 pi) for the angles of a plan; not finite where the closing angle is not.
inline double commanded_phase(const Conditions& c) {
  return c.closing_angle + (c.polarity < 0 ? pi : 0.0);
}

}  // namespace powbench
