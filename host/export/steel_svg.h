#pragma once

#include <string>
#include <vector>

#include "sim/magnetics/steel.h"

/// A B-H curve as SVG: B over log H above, B / (mu0 H) over B below; the rows as marks, what lies beyond them dashed.

namespace powbench::host {

std::string steel_svg(const sim::Steel&, const std::vector<sim::BhRow>& measured, const std::string& title);

}  // namespace powbench::host
