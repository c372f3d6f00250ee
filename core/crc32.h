#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// CRC-32 (reflected polynomial 0xEDB88320, as in Ethernet and zip), guarding records on the wire and at rest.
/// Check value: crc32("123456789") = 0xCBF43926. Shared with firmware: no heap, no exceptions.

namespace powbench {

namespace detail {
inline constexpr std::array<std::uint32_t, 256> crc32_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = (c & 1U) ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}();
}  // namespace detail

/// CRC of `bytes`, continued from `crc` (0 to start).
constexpr std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) {
  crc = ~crc;
  for (const std::uint8_t b : bytes) crc = detail::crc32_table[(crc ^ b) & 0xFFU] ^ (crc >> 8);
  return ~crc;
}

}  // namespace powbench
