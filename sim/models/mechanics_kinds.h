#pragma once

#include "sim/models/mechanics.h"

/// The list of mechanics.cpp, and what its files share.

namespace powbench::sim {

Mechanics plant_mechanics();
Mechanics rigid_mechanics();
Mechanics modal_mechanics();
Mechanics deformable_mechanics();

/// What parts with a mesh do not model: supplies, remanence, a static core apart from the base. `mechanics`: whose name
/// the sentence has.
std::string beyond_deforming_parts(std::string_view mechanics, const Case&);

/// Throws std::invalid_argument with what the mechanics do not model of a case.
void refuse_unknown(const Mechanics&, const Case&);

}  // namespace powbench::sim
