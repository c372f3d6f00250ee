#pragma once

#include <string>
#include <string_view>

namespace powbench::host {

/// Text made safe for element content and attribute values: & < > " ' become entities; bytes that are not UTF-8 and
/// characters XML 1.0 forbids become U+FFFD.
std::string escaped(std::string_view text);

}  // namespace powbench::host
