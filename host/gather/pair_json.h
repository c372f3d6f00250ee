#pragma once

#include <span>
#include <string>

#include "host/compare/pair.h"

namespace powbench::host {

/// Rows of two campaigns as a JSON list; U of each mean and of the difference covers 95.45 %.
std::string pair_json(std::span<const PairRow>, int indent = -1);

}  // namespace powbench::host
