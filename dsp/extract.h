#pragma once

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"

namespace powbench::dsp {

/// Everything that happened in one closing. Pure: equal record and options give equal events, bit for bit.
/// What a record does not show stays unknown (NaN) or not present; bad options or a record whose scale or
/// rate cannot mean anything throw std::invalid_argument.
Events extract_events(const Record&, const ExtractOptions& = {});

}  // namespace powbench::dsp
