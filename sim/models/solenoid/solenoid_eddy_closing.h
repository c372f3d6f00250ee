#pragma once

#include "sim/models/solenoid/solenoid_closing.h"

/// A closing of a solenoid with eddy currents in its solid parts.

namespace powbench::sim {

/// By the implicit midpoint rule with the field in the loop (magnetics/plane/field_transient.h): impacts are plastic,
/// friction counts against the closing. Throws std::invalid_argument for what that rule does not know: another supply
/// than a stiff direct source that stays on behind an ideal switch, and a hold winding; and where the conductivity is
/// 0. std::runtime_error as run_transient.
SolenoidRun simulate_solenoid_eddies(const SolenoidSpecimen&, const FieldOptions&, const SolenoidCase&);

}  // namespace powbench::sim
