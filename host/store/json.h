#pragma once

#include <cmath>
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

/// null for what is not known; a measured value as {value, u}. `Json`: the library's type, whichever the caller has.
template <class Json>
Json json_of(double x) {
  return std::isfinite(x) ? Json(x) : Json(nullptr);
}
template <class Json>
Json json_of(const Measured& m) {
  return {{"value", json_of<Json>(m.value)}, {"u", json_of<Json>(m.u)}};
}

/// Names of the set flags, e.g. "clipped, poor_fit"; empty when none is set.
std::string flag_names(std::uint32_t flags);

/// A number for each quantity, null for what is not known, and `curves`: {channel: {t0, dt, u: [...]}}.
std::string to_json(const InputSpread&);
InputSpread spread_from_json(std::string_view);

}  // namespace powbench::host
