#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "dsp/filter/filter_design.h"
#include "dsp/signal/signal.h"

/// Running a cascade of second-order sections: forward, and forward-backward (zero phase) with honest edges.

namespace powbench::dsp {

/// The record is shorter than the filter remembers: no part of the result would be valid.
class FilterMemoryError : public std::invalid_argument {
 public:
  FilterMemoryError(std::size_t record_samples, std::size_t memory_samples);
};

/// Causal filtering, zero initial state, serial. In place. For long records and many channels: Cascade.
void filter_forward(std::span<const Section>, std::span<double>);

/// Samples until the impulse response stays below `tolerance` of its peak. At most `limit` are tried (then
/// `limit`).
std::size_t filter_memory(std::span<const Section>, double tolerance = 1e-6, std::size_t limit = 20'000'000);

struct ZeroPhase {
  Signal signal;           ///< filtered; `mask_edge` set on `memory` samples at either end
  std::size_t memory = 0;  ///< samples
};

/// Forward, then backward: zero phase, gain |H|^2. Each pass starts from the steady state of its first
/// sample, and the samples within the filter's memory (to 1e-3 of the peak) of either end are masked, because
/// no padding rule can know what came before. Values that are not finite are bridged and masked. Throws
/// FilterMemoryError when the record is shorter than that memory.
ZeroPhase filter_zero_phase(std::span<const Section>, const Signal&);

}  // namespace powbench::dsp
