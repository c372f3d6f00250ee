#pragma once

#include <optional>
#include <string>

#include "host/serve/message.h"

namespace powbench::host {

/// One of the files of the page: /, /page.js, /page.css and the charting library; nothing else. `token` becomes part
/// of the page.
std::optional<Reply> page_file(const std::string& path, const std::string& token);

/// Of every reply but the report: nothing from elsewhere, no script but ours; the charting library colours its legend
/// inline.
inline constexpr const char* page_policy =
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "connect-src 'self'; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'none'";

}  // namespace powbench::host
