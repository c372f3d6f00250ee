#pragma once

#include <string>

#include "sim/study/scene_choice.h"

/// Three errors of a simulated closing in words and as JSON.

namespace powbench::host {

inline constexpr const char* numbers_not_known =
    "how uncertain the specimen's own numbers are is not stated: what they move is not known";

/// Microseconds; "-" for none, "no" where only one of two has the time.
std::string us_text(double seconds);

/// An error that is not known is never a number.
std::string known_or(double seconds);

/// Error of an axis, us: to the rungs above, or, in brackets, from the one below; "?": not known.
std::string axis_text(const sim::AxisError&, std::size_t quantity);

/// One pair that was looked at, as JSON text: times, errors, what is not known, CPU time (null where none is kept).
std::string step_json(const sim::SceneStep&);

}  // namespace powbench::host
