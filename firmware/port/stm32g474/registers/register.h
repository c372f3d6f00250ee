#pragma once

#include <cstddef>
#include <cstdint>

/// One 32-bit peripheral register. The structs in this folder were written by hand from the reference manual RM0440 and
/// are compared with the manufacturer's public device header by compare_header.py.

namespace powbench::firmware::stm32g474 {

struct Register {
  volatile std::uint32_t word;

  std::uint32_t read() const { return word; }
  void write(std::uint32_t value) { word = value; }
  bool any(std::uint32_t mask) const { return (word & mask) != 0; }
  void set(std::uint32_t mask) { word = word | mask; }
  void clear(std::uint32_t mask) { word = word & ~mask; }
  /// The bits of `mask` become those of `value`.
  void change(std::uint32_t mask, std::uint32_t value) { word = (word & ~mask) | value; }
};
static_assert(sizeof(Register) == 4);

constexpr std::uint32_t bit(unsigned n) {
  return std::uint32_t{1} << n;
}

/// The peripheral of type T at `address`.
template <typename T>
T& at(std::uint32_t address) {
  return *reinterpret_cast<T*>(static_cast<std::uintptr_t>(address));
}

/// Lets some three cycles a loop pass.
inline void spin(std::uint32_t loops) {
  while (loops-- > 0) asm volatile("nop");
}

/// Waits until a bit of `mask` is set; false when it does not within `loops`.
inline bool wait_for(const Register& reg, std::uint32_t mask, std::uint32_t loops) {
  while (!reg.any(mask))
    if (loops-- == 0) return false;
  return true;
}

}  // namespace powbench::firmware::stm32g474
