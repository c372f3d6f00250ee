#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

/// Text on a microcontroller: numbers to characters and back, in a fixed buffer. No heap, no exceptions, no
/// printf.

namespace powbench::firmware {

/// Text in memory of fixed size, which a TextOf provides. What does not fit is dropped and remembered in overflowed().
class Text {
 public:
  Text(const Text&) = delete;
  Text& operator=(const Text&) = delete;

  void clear() { size_ = 0, overflowed_ = false; }
  std::string_view view() const { return {data_, size_}; }
  bool overflowed() const { return overflowed_; }

  Text& put(char c) {
    if (size_ < capacity_)
      data_[size_++] = c;
    else
      overflowed_ = true;
    return *this;
  }
  [[gnu::noinline]] Text& put(std::string_view s) {
    for (const char c : s) put(c);
    return *this;
  }
  [[gnu::noinline]] Text& put_int(std::int64_t value) {
    if (value < 0) put('-');
    return put_unsigned(value < 0 ? 0 - static_cast<std::uint64_t>(value)
                                  : static_cast<std::uint64_t>(value));
  }
  [[gnu::noinline]] Text& put_unsigned(std::uint64_t value) {
    char digits[20];
    int n = 0;
    do digits[n++] = static_cast<char>('0' + value % 10);
    while ((value /= 10) != 0);
    while (n > 0) put(digits[--n]);
    return *this;
  }
  [[gnu::noinline]] Text& put_hex32(std::uint32_t value) {
    for (int shift = 28; shift >= 0; shift -= 4) put("0123456789abcdef"[(value >> shift) & 15U]);
    return *this;
  }
  /// `value` / 10^decimals as plain decimal digits, never in exponent form: put_fixed(305, 3) writes "0.305".
  [[gnu::noinline]] Text& put_fixed(std::int64_t value, int decimals) {
    std::uint64_t scale = 1;
    for (int i = 0; i < decimals; ++i) scale *= 10;
    const std::uint64_t magnitude =
        value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
    if (value < 0) put('-');
    put_unsigned(magnitude / scale);
    if (decimals == 0) return *this;
    put('.');
    for (std::uint64_t rest = magnitude % scale; scale > 1; rest %= scale) {
      scale /= 10;
      put(static_cast<char>('0' + rest / scale));
    }
    return *this;
  }

 private:
  char* data_;
  std::size_t capacity_, size_ = 0;
  bool overflowed_ = false;

 protected:
  Text(char* memory, std::size_t capacity) : data_(memory), capacity_(capacity) {}
  ~Text() = default;
};

template <std::size_t Capacity = 512>
class TextOf : public Text {
 public:
  TextOf() : Text(memory_, Capacity) {}

 private:
  char memory_[Capacity]{};
};

/// Holds the longest value of any attribute, a sealed shot.
using LongText = TextOf<1408>;

/// Removes leading and trailing blanks, line ends and NULs (libiio sends a trailing NUL with every string).
constexpr std::string_view trim(std::string_view s) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\0'; };
  while (!s.empty() && blank(s.front())) s.remove_prefix(1);
  while (!s.empty() && blank(s.back())) s.remove_suffix(1);
  return s;
}

/// Whole decimal integer, or nothing: no sign but '-', no exponent, no trailing characters, no overflow.
constexpr std::optional<std::int64_t> parse_int(std::string_view s) {
  s = trim(s);
  const bool negative = !s.empty() && s.front() == '-';
  if (negative) s.remove_prefix(1);
  if (s.empty() || s.size() > 18) return std::nullopt;
  std::int64_t value = 0;
  for (const char c : s) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + (c - '0');
  }
  return negative ? -value : value;
}

}  // namespace powbench::firmware
