#pragma once

#include <span>
#include <string>

#include "sim/study/ladder.h"

/// Picture of the ladder of a closing, as SVG.

namespace powbench::host {

/// Error of the worst of touch, seat and settled against CPU time, both logarithmic: a line for each rung (the true
/// error) and beside it, dashed, what the rung believes.
std::string ladder_svg(const sim::Ladder&, std::span<const sim::Rung>, const std::string& title);

}  // namespace powbench::host
