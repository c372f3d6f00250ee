#pragma once

#include "sim/models/fields.h"

/// The list of fields.cpp, and what its files share.

namespace powbench::sim {

Fields circuit_fields();
Fields table_fields();
Fields solved_fields();
Fields end_fields();

/// Why a specimen has no finite elements at all; empty: it has.
std::string no_elements(const Specimen&);
/// Why a drawing in space has no fields but its table.
std::string has_three_dimensions(const Specimen&);

}  // namespace powbench::sim
