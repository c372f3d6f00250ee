#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "host/compare/pair.h"

namespace powbench::host {

/// Rows of two campaigns as a list; U of each mean and of the difference covers 95.45 %.
nlohmann::ordered_json pair_json(std::span<const PairRow>);

}  // namespace powbench::host
