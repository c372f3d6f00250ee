#pragma once

#include "sim/magnetics/steel.h"
#include "sim/specimen/specimen.h"

namespace powbench::sim {

/// The iron of a magnet: its measured rows, the built-in steel of its name, or without a name the law a B + b B^n.
/// Throws std::invalid_argument for a name that is not built in and for rows that are no curve (`Steel::table`).
Steel steel_of(const Magnet&);

}  // namespace powbench::sim
