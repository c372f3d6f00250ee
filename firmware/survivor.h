#pragma once

#include <cstdint>
#include <string_view>
#include <type_traits>

/// What outlives a reset: a few words in RAM that start-up code neither clears nor loads. A port places one
/// object there (section .noinit), hands it to the controller, and calls record_crash() from its fault
/// handlers after it has forced the gate pin off.

namespace powbench::firmware {

enum class ResetCause : std::uint8_t { power_on, pin, software, watchdog, brown_out };

enum class CrashCause : std::uint8_t {
  none,
  hard_fault,
  memory_fault,
  bus_fault,
  usage_fault,
  nmi,
  assertion,
  stack_overflow
};

/// After power-on the content is arbitrary: a word that is not exactly a mark counts as "off" or "no crash".
struct Survivor {
  static constexpr std::uint32_t gate_on_mark = 0x6A7E0FF1U;
  static constexpr std::uint32_t crash_mark = 0xC0DEFA17U;

  std::uint32_t gate;
  std::uint32_t crash;
  std::uint32_t cause;            ///< CrashCause
  std::uint32_t program_counter;  ///< where it happened
  std::uint32_t link_register;    ///< where that was called from
  std::uint32_t check;            ///< makes a half-written crash record invalid

  void note_gate(bool on) { gate = on ? gate_on_mark : 0; }
  bool gate_was_on() const { return gate == gate_on_mark; }

  void record_crash(CrashCause why, std::uint32_t pc, std::uint32_t lr) {
    cause = static_cast<std::uint32_t>(why);
    program_counter = pc;
    link_register = lr;
    crash = crash_mark;
    check = sum();
  }
  bool has_crash() const { return crash == crash_mark && check == sum() && cause != 0 && cause <= 7; }
  void forget() { gate = crash = cause = program_counter = link_register = check = 0; }

 private:
  std::uint32_t sum() const {
    return ((crash * 31U + cause) * 31U + program_counter) * 31U + link_register + 1U;
  }
};
static_assert(std::is_trivially_default_constructible_v<Survivor>);

/// What the port tells the controller once, before the first block.
struct BootReport {
  ResetCause cause = ResetCause::power_on;
  Survivor* survivor = nullptr;  ///< kept and written from then on; nullptr: the port has no such memory
  bool stored_config_intact = true;
  std::string_view
      unfit{};  ///< why this board must not be armed; empty: it may. Lives as long as the program
};

}  // namespace powbench::firmware
