#pragma once

#include <string>

#include "core/record.h"

namespace powbench::host {

/// A record as CSV: one header line `time [s],pvdf_a [N],...`, SI units, one line a sample. Time is seconds after
/// switch-on on the sampling clock; known sensor delays are not applied and droop is not undone: both stand in the
/// calibration file that goes with it (host/import/calibration.h). A lost sample is an empty cell. Times and values
/// carry the digits that give the same doubles again. `powbench import` and `powbench events` read it back.
std::string to_csv(const Record&);

}  // namespace powbench::host
