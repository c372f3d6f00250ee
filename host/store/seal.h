#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
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
  std::string hex() const { return sha256_hex(content_); }

 private:
  std::string content_;
};

}  // namespace powbench::host
