#pragma once

#include <string>

/// The colours of pictures of fields and surfaces.

namespace powbench::host {

/// `#rrggbb`, light to dark for a share of 0 .. 1; beyond, the end's colour.
std::string scale_colour(double share);

}  // namespace powbench::host
