#pragma once

#include <string>
#include <string_view>

namespace powbench::host {

/// A configuration file with another value for one key, as a person would have edited it: every other line, the order
/// and the comments stay. `value` is TOML; "" takes the key out. A line `#key = ...` of a template becomes the key's
/// line; a key that is new stands behind the last line of its section, and a section that is new at the end of the
/// file. Values over several lines become one.
std::string with_value(const std::string& text, std::string_view section, std::string_view key,
                       const std::string& value);

/// A plan's text with order = "by_hand": nothing of it was planned, its shots are single closings.
std::string by_hand_plan(const std::string& plan_text);

}  // namespace powbench::host
