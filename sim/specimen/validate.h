#pragma once

#include <string>
#include <vector>

#include "sim/specimen/specimen.h"

/// Checks a specimen against the physics and against slips of unit.

namespace powbench::sim {

/// One value outside its range. Keys are those of the specimen file, e.g. `bridges.gap_mm`.
struct SpecimenError {
  std::string key;
  std::string value;  ///< as given, in the unit of the key
  std::string range;  ///< what is allowed, in the unit of the key
};

/// All errors of a specimen; empty = usable. The ranges hold any contactor of 6 A to 1000 A; a length given
/// in the wrong unit, a negative mass, a zero stiffness or a gap larger than the travel falls outside.
std::vector<SpecimenError> validate(const Specimen&);

/// Throws std::invalid_argument that lists all errors.
void require_valid(const Specimen&);

}  // namespace powbench::sim
