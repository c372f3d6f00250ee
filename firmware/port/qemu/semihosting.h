#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// ARM semihosting: the debugger (here the emulator) does input and output for the processor. Reference: Arm,
/// "Semihosting for AArch32 and AArch64". Never part of an image for real hardware, where it would halt.

namespace powbench::firmware::semihosting {

enum class Open : std::uint32_t { read = 1, write = 5 };  // "rb", "wb"

inline std::uint32_t call(std::uint32_t operation, const void* block) {
  register std::uint32_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = block;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

/// Handle of the host's file, or a negative number.
inline std::int32_t open(const char* path, std::size_t length, Open mode) {
  const std::uint32_t block[] = {reinterpret_cast<std::uintptr_t>(path), static_cast<std::uint32_t>(mode),
                                 static_cast<std::uint32_t>(length)};
  return static_cast<std::int32_t>(call(0x01, block));
}

/// Bytes read; 0 at the end of the file. May be fewer than asked for.
inline std::size_t read(std::int32_t handle, std::span<std::uint8_t> to) {
  const std::uint32_t block[] = {static_cast<std::uint32_t>(handle),
                                 reinterpret_cast<std::uintptr_t>(to.data()),
                                 static_cast<std::uint32_t>(to.size())};
  const std::uint32_t missing = call(0x06, block);  // the call answers with what it did not read
  return missing > to.size() ? 0 : to.size() - missing;
}

/// True when all bytes were written.
inline bool write(std::int32_t handle, std::span<const std::uint8_t> from) {
  const std::uint32_t block[] = {static_cast<std::uint32_t>(handle),
                                 reinterpret_cast<std::uintptr_t>(from.data()),
                                 static_cast<std::uint32_t>(from.size())};
  return call(0x05, block) == 0;
}

/// The words after `arg=` on the emulator's command line; empty: none, or too long.
inline std::string_view arguments(std::span<char> memory) {
  struct {
    char* text;
    std::uint32_t length;
  } block{memory.data(), static_cast<std::uint32_t>(memory.size())};
  return call(0x15, &block) == 0 ? std::string_view(block.text, block.length) : std::string_view();
}

/// Text ending in a zero, to the emulator's console.
inline void say(const char* text) {
  call(0x04, text);
}

/// Ends the emulation with an exit code.
[[noreturn]] inline void exit(std::uint32_t code) {
  const std::uint32_t block[] = {0x20026, code};  // ADP_Stopped_ApplicationExit
  call(0x20, block);
  for (;;) {
  }
}

}  // namespace powbench::firmware::semihosting
