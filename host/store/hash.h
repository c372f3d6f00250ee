#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace powbench::host {

/// SHA-256 in 64 hexadecimal digits. Names content: equal hash, equal bytes.
std::string sha256_hex(std::span<const std::uint8_t> bytes);
std::string sha256_hex(std::string_view text);

/// The same of content that comes in parts and is never held as a whole.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view part);
  /// Of all parts; nothing may be added after it.
  std::string hex();

 private:
  std::shared_ptr<void> context_;
};

}  // namespace powbench::host
