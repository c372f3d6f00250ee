#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "host/store/store.h"

/// Content of a point as bytes: numbers as they lie in memory (little-endian, every bit kept), lists and texts behind
/// their length.

namespace powbench::host {

class ByteWriter {
 public:
  ByteWriter& add(double value) { return raw(&value, sizeof value); }
  ByteWriter& add(std::int64_t value) { return raw(&value, sizeof value); }
  ByteWriter& add(std::string_view text) {
    return add(static_cast<std::int64_t>(text.size())).raw(text.data(), text.size());
  }
  ByteWriter& add(const std::vector<double>& list) {
    return add(static_cast<std::int64_t>(list.size())).raw(list.data(), list.size() * sizeof(double));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  ByteWriter& raw(const void* from, std::size_t size) {
    if (size > 0) bytes_.append(static_cast<const char*>(from), size);
    return *this;
  }
  std::string bytes_;
};

/// Reads in the same order. Throws StoreError where the bytes end early.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}
  double number() { return value<double>(); }
  std::int64_t integer() { return value<std::int64_t>(); }
  std::string text() { return std::string(take(length(1))); }
  std::vector<double> numbers() {
    const std::size_t n = length(sizeof(double));
    std::vector<double> list(n);
    const std::string_view from = take(n * sizeof(double));
    if (n > 0) std::memcpy(list.data(), from.data(), from.size());
    return list;
  }

 private:
  template <class T>
  T value() {
    T v;
    std::memcpy(&v, take(sizeof v).data(), sizeof v);
    return v;
  }
  std::size_t length(std::size_t each) {
    const std::int64_t n = integer();
    if (n < 0 || static_cast<std::uint64_t>(n) > left_.size() / each) ended();
    return static_cast<std::size_t>(n);
  }
  std::string_view take(std::size_t n) {
    if (n > left_.size()) ended();
    const std::string_view part = left_.substr(0, n);
    left_.remove_prefix(n);
    return part;
  }
  [[noreturn]] static void ended() {
    throw StoreError("a point of the store is shorter than it should be; compute it anew in another store");
  }
  std::string_view left_;
};

}  // namespace powbench::host
