#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// CRC-32 (reflected polynomial 0xEDB88320, as in Ethernet and zip), guarding records on the wire and at rest.
/// Check value: crc32("123456789") = 0xCBF43926. Shared with firmware: no heap, no exceptions.

namespace powbench {

namespace detail {
/// Row k takes a byte that is followed by k more bytes of its word.
inline constexpr std::array<std::array<std::uint32_t, 256>, 4> crc32_tables = [] {
  std::array<std::array<std::uint32_t, 256>, 4> tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = (c & 1U) ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    tables[0][i] = c;
  }
  for (std::size_t row = 1; row < 4; ++row)
    for (std::size_t i = 0; i < 256; ++i)
      tables[row][i] = tables[0][tables[row - 1][i] & 0xFFU] ^ (tables[row - 1][i] >> 8);
  return tables;
}();
}  // namespace detail

/// CRC of `bytes`, continued from `crc` (0 to start). Four bytes at a step (M. E. Kounavis and F. L. Berry, "A
/// systematic approach to building high performance software-based CRC generators", ISCC 2005).
constexpr std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) {
  const auto& table = detail::crc32_tables;
  const std::uint8_t* p = bytes.data();
  std::size_t left = bytes.size();
  crc = ~crc;
  for (; left >= 4; left -= 4, p += 4) {
    crc ^= static_cast<std::uint32_t>(p[0]) | static_cast<std::uint32_t>(p[1]) << 8 |
           static_cast<std::uint32_t>(p[2]) << 16 | static_cast<std::uint32_t>(p[3]) << 24;
    crc = table[3][crc & 0xFFU] ^ table[2][crc >> 8 & 0xFFU] ^ table[1][crc >> 16 & 0xFFU] ^
          table[0][crc >> 24];
  }
  for (; left > 0; --left, ++p) crc = table[0][(crc ^ *p) & 0xFFU] ^ (crc >> 8);
  return ~crc;
}

}  // namespace powbench
