#pragma once

#include "bench/fault_bench.h"

/// The causes of the faults: what is done to a running bench so that a fault appears.

namespace powbench::bench {

using Inject = void (*)(FaultBench&);

/// Brings the fault about, at sample FaultBench::inject_at.
Inject injection_of(firmware::Fault);

/// Damages one bit of the configuration; a second call repairs it.
void flip_config_bit(FaultBench&);

}  // namespace powbench::bench
