#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace powbench::host {

/// SHA-256 in 64 hexadecimal digits. Names content: equal hash, equal bytes.
std::string sha256_hex(std::span<const std::uint8_t> bytes);
std::string sha256_hex(std::string_view text);

}  // namespace powbench::host
