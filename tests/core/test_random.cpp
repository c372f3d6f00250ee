#include "core/random.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace powbench;

TEST_CASE("splitmix64 gives the published sequence", "[random]") {
  // The sequence that other implementations of splitmix64 list for this seed.
  std::uint64_t state = 1234567;
  for (const std::uint64_t expected : {6457827717110365317ULL, 3203168211198807973ULL, 9817491932198370423ULL,
                                       4593380528125082431ULL, 16408922859458223821ULL})
    CHECK(splitmix64(state) == expected);
}

TEST_CASE("Random is xoshiro256++ over a splitmix64 state", "[random]") {
  std::uint64_t seed = 42;
  std::array<std::uint64_t, 4> s{};
  for (auto& word : s) word = splitmix64(seed);
  const auto rotate = [](std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); };
  Random random(42);
  for (int i = 0; i < 1000; ++i) {
    REQUIRE(random.next() == rotate(s[0] + s[3], 23) + s[0]);
    const std::uint64_t t = s[1] << 17;
    s[2] ^= s[0], s[3] ^= s[1], s[1] ^= s[2], s[0] ^= s[3], s[2] ^= t;
    s[3] = rotate(s[3], 45);
  }
}

TEST_CASE("bounded integers stay in range and are even", "[random]") {
  Random random(7);
  for (const std::uint64_t n : {1ULL, 2ULL, 3ULL, 7ULL, 1ULL << 63, (1ULL << 63) + 1, ~0ULL})
    for (int i = 0; i < 1000; ++i) REQUIRE(random.below(n) < n);

  constexpr std::size_t bins = 7;
  constexpr int draws = 70'000;
  std::array<int, bins> counts{};
  for (int i = 0; i < draws; ++i) ++counts[random.below(bins)];
  double chi_square = 0;
  for (const int count : counts) chi_square += std::pow(count - draws / 7.0, 2) / (draws / 7.0);
  CHECK(chi_square < 22.5);  // 99.9 % point for 6 degrees of freedom
}

TEST_CASE("uniform numbers lie in [0, 1) with mean 1/2 and variance 1/12", "[random]") {
  Random random(3);
  constexpr int n = 200'000;
  double sum = 0, square = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform();
    REQUIRE((x >= 0.0 && x < 1.0));
    sum += x;
    square += x * x;
  }
  const double mean = sum / n;
  CHECK(std::fabs(mean - 0.5) < 4 * std::sqrt(1.0 / 12 / n));
  CHECK(std::fabs(square / n - mean * mean - 1.0 / 12) < 4 * std::sqrt(1.0 / 180 / n));
}

TEST_CASE("normal numbers follow the error function, tails included", "[random]") {
  Random random(11);
  constexpr int n = 400'000;
  const std::vector<double> edges{-4.0, -3.5, -3.0, -2.0, -1.0, -0.3, 0.0, 0.3, 1.0, 2.0, 3.0, 3.5, 4.0};
  std::vector<int> below(edges.size(), 0);
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    for (std::size_t k = 0; k < edges.size(); ++k) below[k] += x < edges[k];
  }
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const double p = 0.5 * std::erfc(-edges[k] / std::sqrt(2.0));
    CAPTURE(edges[k]);
    CHECK(std::fabs(below[k] - n * p) < 4.5 * std::sqrt(n * p * (1 - p)) + 1);
  }
}

TEST_CASE("equal seeds give equal numbers, different seeds different ones", "[random]") {
  Random a(5), b(5), c(6);
  bool all_equal = true;
  for (int i = 0; i < 100; ++i) {
    const double x = a.normal();
    REQUIRE(x == b.normal());
    all_equal = all_equal && x == c.normal();
  }
  CHECK_FALSE(all_equal);
}
