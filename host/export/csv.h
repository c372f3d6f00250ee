#pragma once

#include <string>

#include "core/record.h"

namespace powbench::host {

/// A record as CSV: one header line `time [s],pvdf_a [N],...`, SI units, one line a sample. Time is seconds after
/// switch-on on the sampling clock; known sensor delays are not applied, they stand in the store. Values carry 9
/// significant digits, more than 16 bits hold.
std::string to_csv(const Record&);

}  // namespace powbench::host
