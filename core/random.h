#pragma once

#include <array>
#include <cmath>
#include <cstdint>

/// Seeded random numbers that are the same on every standard library: nothing here leaves the distribution to the
/// implementation. Generator: xoshiro256++ (period 2^256 - 1), seeded by splitmix64.

namespace powbench {

/// One step of splitmix64: a good hash of a counter, used for seeds.
constexpr std::uint64_t splitmix64(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9E3779B97F4A7C15ULL);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) {
    for (auto& word : state_) word = splitmix64(seed);
  }

  constexpr std::uint64_t next() {
    const std::uint64_t result = rotate(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = rotate(state_[3], 45);
    return result;
  }

  /// Uniform on [0, 1), 53 bits.
  constexpr double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

  /// Uniform integer on [0, n), without modulo bias. n > 0.
  constexpr std::uint64_t below(std::uint64_t n) {
    const std::uint64_t limit = UINT64_MAX - (UINT64_MAX % n + 1) % n;
    std::uint64_t x = next();
    while (x > limit) x = next();
    return x % n;
  }

  /// Standard normal, by the ziggurat of Marsaglia and Tsang in 128 layers; exact in distribution.
  double normal() {
    const Ziggurat& z = ziggurat();
    for (;;) {
      const std::uint64_t bits = next();
      const std::size_t layer = bits & 127U;
      const double u = 2.0 * static_cast<double>(bits >> 11) * 0x1.0p-53 - 1.0;
      const double x = u * z.edge[layer];
      if (std::fabs(x) < z.edge[layer + 1]) return x;  // inside the layer's rectangle: 98.8 % of all draws
      if (layer == 0) return tail(u < 0.0);
      const double low = z.height[layer], high = z.height[layer + 1];
      if (low + uniform() * (high - low) < std::exp(-0.5 * x * x)) return x;
    }
  }

 private:
  static constexpr double tail_start = 3.442619855899;       // r for 128 layers
  static constexpr double layer_area = 9.91256303526217e-3;  // v for 128 layers

  struct Ziggurat {
    std::array<double, 129> edge{};    ///< x_i, falling; edge[0] = v / f(r) is the base layer's pseudo-width
    std::array<double, 129> height{};  ///< f(x_i) = exp(-x_i^2 / 2)
  };

  static const Ziggurat& ziggurat() {
    static const Ziggurat table = [] {
      Ziggurat z;
      double f = std::exp(-0.5 * tail_start * tail_start);
      z.edge[0] = layer_area / f;
      z.edge[1] = tail_start;
      z.edge[128] = 0.0;
      for (std::size_t i = 2; i < 128; ++i) {
        z.edge[i] = std::sqrt(-2.0 * std::log(layer_area / z.edge[i - 1] + f));
        f = std::exp(-0.5 * z.edge[i] * z.edge[i]);
      }
      for (std::size_t i = 1; i < 129; ++i) z.height[i] = std::exp(-0.5 * z.edge[i] * z.edge[i]);
      return z;
    }();
    return table;
  }

  double tail(bool negative) {
    double x = 0.0, y = 0.0;
    do {
      x = -std::log(1.0 - uniform()) / tail_start;
      y = -std::log(1.0 - uniform());
    } while (y + y < x * x);
    return negative ? -(tail_start + x) : tail_start + x;
  }

  static constexpr std::uint64_t rotate(std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

  std::array<std::uint64_t, 4> state_{};
};

}  // namespace powbench
