#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

/// Numbers out of the bytes of a file, of either byte order, never beyond its end.

namespace powbench::host {

/// The bytes end where more are needed. Caught by the importer, which knows the name of the file.
class CutShort : public std::runtime_error {
 public:
  CutShort() : std::runtime_error("the file ends in the middle: it is cut or damaged") {}
};

enum class Number : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };
constexpr std::size_t size_of(Number n) {
  constexpr std::size_t sizes[]{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<std::size_t>(n)];
}

template <std::integral T>
T integer_at(const char* at, bool big) {
  std::make_unsigned_t<T> v = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    v = static_cast<std::make_unsigned_t<T>>(
        v | static_cast<std::make_unsigned_t<T>>(static_cast<unsigned char>(at[big ? sizeof(T) - 1 - i : i]))
                << (8 * i));
  return static_cast<T>(v);
}

/// Any number as a double; NaN for what is not finite.
inline double number_at(const char* at, Number n, bool big) {
  const auto finite = [](double v) { return std::isfinite(v) ? v : std::nan(""); };
  switch (n) {
    case Number::i8:
      return static_cast<double>(integer_at<std::int8_t>(at, big));
    case Number::u8:
      return static_cast<double>(integer_at<std::uint8_t>(at, big));
    case Number::i16:
      return static_cast<double>(integer_at<std::int16_t>(at, big));
    case Number::u16:
      return static_cast<double>(integer_at<std::uint16_t>(at, big));
    case Number::i32:
      return static_cast<double>(integer_at<std::int32_t>(at, big));
    case Number::u32:
      return static_cast<double>(integer_at<std::uint32_t>(at, big));
    case Number::i64:
      return static_cast<double>(integer_at<std::int64_t>(at, big));
    case Number::u64:
      return static_cast<double>(integer_at<std::uint64_t>(at, big));
    case Number::f32:
      return finite(static_cast<double>(std::bit_cast<float>(integer_at<std::uint32_t>(at, big))));
    case Number::f64:
      return finite(std::bit_cast<double>(integer_at<std::uint64_t>(at, big)));
  }
  return std::nan("");
}

/// Reads on from the front of some bytes.
class Bytes {
 public:
  explicit Bytes(std::string_view all, bool big = false) : left_(all), big_(big) {}

  std::size_t left() const { return left_.size(); }
  bool big() const { return big_; }
  std::string_view take(std::uint64_t n) {
    if (n > left_.size()) throw CutShort();
    const std::string_view part = left_.substr(0, static_cast<std::size_t>(n));
    left_.remove_prefix(static_cast<std::size_t>(n));
    return part;
  }
  template <std::integral T>
  T integer() {
    return integer_at<T>(take(sizeof(T)).data(), big_);
  }
  double number(Number n) { return number_at(take(size_of(n)).data(), n, big_); }
  /// A 32-bit length, then as many bytes.
  std::string text() { return std::string(take(integer<std::uint32_t>())); }

 private:
  std::string_view left_;
  bool big_;
};

}  // namespace powbench::host
