#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/text.h"

/// Request lines of the IIOD text protocol, taken apart. Used by the responder and by the bridge in front of
/// it, which must agree on where a request ends.

namespace powbench::firmware::iiod {

/// Compares without regard to case; `upper` is written in capitals.
constexpr bool same_word(std::string_view a, std::string_view upper) {
  if (a.size() != upper.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const char c = (a[i] >= 'a' && a[i] <= 'z') ? static_cast<char>(a[i] - 'a' + 'A') : a[i];
    if (c != upper[i]) return false;
  }
  return true;
}

/// Channel mask: up to eight hexadecimal digits.
constexpr bool parse_mask(std::string_view s, std::uint32_t& mask) {
  if (s.empty() || s.size() > 8) return false;
  mask = 0;
  for (const char c : s) {
    std::uint32_t digit = 0;
    if (c >= '0' && c <= '9')
      digit = static_cast<std::uint32_t>(c - '0');
    else if (c >= 'a' && c <= 'f')
      digit = static_cast<std::uint32_t>(c - 'a' + 10);
    else if (c >= 'A' && c <= 'F')
      digit = static_cast<std::uint32_t>(c - 'A' + 10);
    else
      return false;
    mask = mask << 4 | digit;
  }
  return true;
}

/// A request split at blanks. Requests have at most six words.
struct Words {
  std::array<std::string_view, 6> word{};
  std::size_t count = 0;
  bool too_many = false;

  explicit Words(std::string_view line) {
    while (!line.empty()) {
      const std::size_t start = line.find_first_not_of(" \t\r");
      if (start == std::string_view::npos) return;
      line.remove_prefix(start);
      const std::size_t end = line.find_first_of(" \t\r");
      if (count == word.size()) {
        too_many = true;
        return;
      }
      const std::size_t length = end == std::string_view::npos ? line.size() : end;
      word[count++] = {line.data(), length};  // substr() could throw
      line.remove_prefix(length);
    }
  }
  std::string_view operator[](std::size_t i) const { return i < count ? word[i] : std::string_view{}; }
};

/// Bytes of payload that follow the line of a WRITE; nothing: the line is refused and no payload follows.
inline std::optional<std::int64_t> payload_length(const Words& words) {
  const auto length = words.count >= 3 ? parse_int(words[words.count - 1]) : std::nullopt;
  if (!length || *length < 0 || *length > 1'000'000) return std::nullopt;
  return length;
}

}  // namespace powbench::firmware::iiod
