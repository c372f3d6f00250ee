#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "core/conditions.h"
#include "core/events.h"
#include "host/store/input_spread.h"

namespace powbench::host {

/// Lossless JSON of the shared structs: SI, 17 digits, null for what is unknown. The same text stands in the store and
/// comes out of `--json`. Reading throws std::invalid_argument for text that is not such an object.
std::string to_json(const Events&, int indent = -1);
std::string to_json(const Conditions&, int indent = -1);
Events events_from_json(std::string_view);
Conditions conditions_from_json(std::string_view);

/// null for what is not known; a measured value as {value, u}.
nlohmann::ordered_json json_of(double);
nlohmann::ordered_json json_of(const Measured&);

/// Names of the set flags, e.g. "clipped, poor_fit"; empty when none is set.
std::string flag_names(std::uint32_t flags);

/// A number for each quantity, null for what is not known, and `curves`: {channel: {t0, dt, u: [...]}}.
std::string to_json(const InputSpread&);
InputSpread spread_from_json(std::string_view);

}  // namespace powbench::host
