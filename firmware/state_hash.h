#pragma once

#include <bit>
#include <cstdint>

/// A running hash of what a controller has decided, to compare two ports block by block: equal hashes mean
/// that every estimate, state and gate edge since the start was the same, to the last bit.

namespace powbench::firmware {

/// FNV-1a over 32-bit words (the published 32-bit offset and prime), with the high half folded down: a plain
/// product never carries a high bit to a lower one.
class StateHash {
 public:
  void add(std::uint32_t word) {
    value_ = (value_ ^ word) * 16777619U;
    value_ ^= value_ >> 15;
  }
  void add(std::int64_t value) {
    add(static_cast<std::uint32_t>(value));
    add(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value) >> 32));
  }
  void add(float value) { add(std::bit_cast<std::uint32_t>(value)); }

  std::uint32_t value() const { return value_; }

 private:
  std::uint32_t value_ = 2166136261U;
};

}  // namespace powbench::firmware
