#include "core/crc32.h"

#include <catch2/catch.hpp>
#include <string_view>
#include <vector>

#include "core/random.h"

using namespace powbench;

TEST_CASE("CRC-32 has its check value, also when it is continued at any byte") {
  const std::string_view text = "123456789";
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
    CHECK(crc32(bytes.subspan(cut), crc32(bytes.first(cut))) == 0xCBF43926);
  CHECK(crc32({}) == 0);
}

TEST_CASE("CRC-32 equals its definition, bit by bit, at every length") {
  Random random(5);
  std::vector<std::uint8_t> bytes(67);
  for (auto& b : bytes) b = static_cast<std::uint8_t>(random.next());
  for (std::size_t n = 0; n <= bytes.size(); ++n) {
    std::uint32_t crc = ~0U;
    for (std::size_t i = 0; i < n; ++i) {
      crc ^= bytes[i];
      for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xEDB88320U : crc >> 1;
    }
    CHECK(crc32({bytes.data(), n}) == ~crc);
  }
}
