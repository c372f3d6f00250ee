#pragma once

#include <string>

#include "host/store/input_spread.h"
#include "rigs/simulated_record.h"

/// A simulated closing as the content of a point (host/store/points.h).

namespace powbench::host {

/// One simulated closing with its events, and what the uncertainty of its conditions leaves open.
struct SimulatedPoint {
  Record record;
  std::int64_t field_states = 0, field_beyond = 0;  ///< as in rigs::SimulatedClosing
  Events events;
  InputSpread prediction;
};

/// Without Record::conditions, which are part of what the point depends on. Samples are packed without loss.
std::string bytes_of(const SimulatedPoint&);
/// Throws StoreError where the bytes are no such point.
SimulatedPoint simulated_point(const std::string& bytes, const Conditions&);

}  // namespace powbench::host
