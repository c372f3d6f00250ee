#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "host/store/hash.h"

namespace powbench::host {

/// Checksum of one row: SHA-256 over its values, each with its length, in a fixed order. Kept in the row and checked
/// when it is read, so that a flipped bit is reported as damage and never read as a result.
class Seal {
 public:
  Seal& add(std::string_view text) {
    content_ += std::to_string(text.size()) + ':';
    content_ += text;
    if (content_.size() >= most_held) {
      if (!begun_) begun_.emplace();
      begun_->add(content_);
      content_.clear();
    }
    return *this;
  }
  Seal& add(std::int64_t value) { return add(std::string_view(std::to_string(value))); }
  Seal& add(int value) { return add(static_cast<std::int64_t>(value)); }
  Seal& add(double value) {
    if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();  // one of many
    char bits[sizeof value];
    std::memcpy(bits, &value, sizeof value);
    return add(std::string_view(bits, sizeof bits));
  }
  /// Nothing may be added after it.
  std::string hex() {
    if (!begun_) return sha256_hex(content_);
    begun_->add(content_);
    return begun_->hex();
  }

 private:
  static constexpr std::size_t most_held = 1 << 16;
  std::string content_;          ///< not in `begun_` yet
  std::optional<Sha256> begun_;  ///< of what is long: a whole sweep, say
};

}  // namespace powbench::host
