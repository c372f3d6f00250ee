#include "host/store/packing.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/random.h"

using namespace powbench;
using namespace powbench::host;

namespace {

using Channels = std::vector<std::vector<std::int16_t>>;

std::vector<std::uint8_t> pack(const Channels& channels) {
  return pack_samples(std::vector<Samples>(channels.begin(), channels.end()));
}

bool unpack(std::span<const std::uint8_t> bytes, Channels& channels) {
  return unpack_samples(bytes, std::vector<std::span<std::int16_t>>(channels.begin(), channels.end()));
}

/// Noise of some bits, now and then a step, a ramp, a swing over the whole range or a rest.
std::vector<std::int16_t> wild(Random& random, std::size_t n) {
  std::vector<std::int16_t> x(n);
  double level = 0, slope = 0, noise = 1;
  for (std::int16_t& v : x) {
    if (random.below(100) == 0)
      level = 65536 * (random.uniform() - 0.5), slope = 200 * (random.uniform() - 0.5);
    if (random.below(100) == 0) noise = std::pow(2.0, 16 * random.uniform()) - 1;
    if (random.below(200) == 0) noise = slope = 0;
    level += slope;
    v = static_cast<std::int16_t>(static_cast<std::uint16_t>(std::llround(level + noise * random.normal())));
  }
  return x;
}

}  // namespace

TEST_CASE("samples come back from their packing, whatever they are", "[store][packing]") {
  Random random(5);
  for (int i = 0; i < 400; ++i) {
    Channels x;
    const std::size_t n = i < 140 ? static_cast<std::size_t>(i) : random.below(3000);
    for (std::size_t k = 0; k < 1 + random.below(4); ++k) x.push_back(wild(random, n));
    if (n > 1) x[0][0] = -32768, x[0][1] = 32767;
    const auto bytes = pack(x);
    CHECK(bytes.size() <= x.size() * (131 + 2 * n + n / 4));
    Channels back(x.size(), std::vector<std::int16_t>(n, 99));
    REQUIRE(unpack(bytes, back));
    REQUIRE(back == x);
    // one sample more or less, a byte too many, a cut: never taken for the record
    if (n < 65 || bytes.empty()) continue;
    Channels other(x.size(), std::vector<std::int16_t>(n + 64));
    CHECK_FALSE(unpack(bytes, other));
    other.assign(x.size(), std::vector<std::int16_t>(n - 64));
    CHECK_FALSE(unpack(bytes, other));
    CHECK_FALSE(unpack(std::span(bytes).first(random.below(bytes.size())), back));
  }
}

TEST_CASE("the bytes of a packing are those of its description", "[store][packing]") {
  // a ramp: z(10) = 20 takes five bits, the second block has no second differences
  std::vector<std::int16_t> ramp;
  for (int i = 0; i < 128; ++i) ramp.push_back(static_cast<std::int16_t>(10 * (i + 1)));
  const auto bytes = pack({ramp});
  REQUIRE(bytes.size() == 1 + 5 * 8 + 1);
  CHECK(bytes[0] == (1U << 5 | 5U));
  CHECK(bytes[1] == 0x94);  // 10100, and the three low bits of the next 10100
  CHECK(bytes[41] == (2U << 5 | 0U));
  // a level far from zero: offsets from the smallest
  std::vector<std::int16_t> level(64, 1000);
  level[1] = 1001;
  const auto flat = pack({level});
  REQUIRE(flat.size() == 3 + 8);
  CHECK(flat[0] == 1);
  CHECK((flat[1] | flat[2] << 8) == 1000);
  CHECK(flat[3] == 2);
}

TEST_CASE("any bytes are unpacked or refused, and nothing else is touched", "[store][packing]") {
  Random random(6);
  for (int i = 0; i < 20'000; ++i) {
    Channels x{wild(random, 200)};
    auto bytes = pack(x);
    for (std::size_t k = 0; k < 1 + random.below(3); ++k)
      bytes[random.below(bytes.size())] = static_cast<std::uint8_t>(random.below(256));
    bytes.resize(random.below(bytes.size() + 1));
    std::vector<std::int16_t> room(264, 0x5A5A);
    std::vector<std::span<std::int16_t>> to{std::span(room).subspan(32, 200)};
    unpack_samples(bytes, to);
    for (std::size_t k = 0; k < 32; ++k) REQUIRE((room[k] == 0x5A5A && room[232 + k] == 0x5A5A));
  }
}
