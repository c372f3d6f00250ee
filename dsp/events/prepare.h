#pragma once

#include "core/record.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"

/// The filtered signals for display and report. No event is ever decided on these.

namespace powbench::dsp {

/// SI, time after switch-on; a channel that is absent or too short for the filter is empty.
struct Prepared {
  Signal pvdf_a, pvdf_b;  ///< N: offset, hum and droop removed, zero-phase low-pass (display_hertz)
  Signal laser;           ///< m, 0 = open position
  Signal coil_current;    ///< A, zero from the pre-trigger
  Signal coil_voltage, mains_voltage, contact_voltage;  ///< V
  std::size_t edge_samples = 0;  ///< memory of the display low-pass: masked at either end
};

Prepared prepare(const Record&, const ExtractOptions& = {});

}  // namespace powbench::dsp
