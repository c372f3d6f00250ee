#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/crc32.h"

/// Watches constant bytes in RAM: their CRC is computed again and again, a few bytes a block.

namespace powbench::firmware {

class ConfigGuard {
 public:
  static constexpr std::size_t bytes_per_block = 16;

  explicit ConfigGuard(std::span<const std::uint8_t> bytes) : bytes_(bytes), expected_(crc32(bytes)) {}

  /// Goes on; true when a pass has just been completed, then intact() is fresh.
  bool step() {
    const std::size_t left = bytes_.size() - at_;
    const std::size_t n = left < bytes_per_block ? left : bytes_per_block;
    crc_ = crc32(bytes_.subspan(at_, n), crc_);
    at_ += n;
    if (at_ < bytes_.size()) return false;
    intact_ = crc_ == expected_;
    at_ = 0;
    crc_ = 0;
    return true;
  }
  bool intact() const { return intact_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::uint32_t expected_, crc_ = 0;
  std::size_t at_ = 0;
  bool intact_ = true;
};

}  // namespace powbench::firmware
