#pragma once

#include <string>

#include "sim/magnetics/space/magnet_field.h"

namespace powbench::bench {

/// |B| of a solved core as an SVG: the plane y = 0 through the middle of the stack, and the plane x through the
/// middle of the window, where the stack ends and the coil's heads stand out.
std::string core_picture(const sim::space::MagnetField&, const sim::space::FieldPoint&,
                         const sim::MagnetDesign&, double gap);

}  // namespace powbench::bench
