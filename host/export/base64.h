#pragma once

#include <string>

namespace powbench::host {

/// RFC 4648, with padding.
std::string base64(const std::string& bytes);

}  // namespace powbench::host
