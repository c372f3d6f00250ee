#pragma once

#include "host/cli/specimen_verb.h"
#include "host/cli/verbs.h"

/// `powbench sim`, `field` and `specimen describe` of a solenoid. All throw BadInput.

namespace powbench::host {

/// One closing, on wish an opening: times, currents, a table or a picture over time.
Exit simulate_solenoid(const SimArgs&);

/// Throws BadInput for options of `sim` that only a solenoid has.
void refuse_solenoid_options(const SimArgs&);

/// Table W(psi, gap) and pictures of the field, open, half way and closed.
Exit show_solenoid_field(const FieldArgs&);

/// Current and power, and the static pull beside spring and load over the travel.
Exit describe_solenoid(const SpecimenArgs&);

}  // namespace powbench::host
