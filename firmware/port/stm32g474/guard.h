#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/survivor.h"

/// Watchdog, supply monitor, reset cause, and what the last fault left behind.

namespace powbench::firmware::stm32g474 {

/// Lives in memory that no start clears: what happened before the reset.
struct Postmortem {
  std::uint32_t magic;
  std::uint32_t kept;  ///< 1: this memory has outlived the reset, 0: its content was arbitrary
  std::uint32_t boots;
  std::uint32_t exception;  ///< number of the exception that ended the last run; 0: none did
  std::uint32_t program_counter, link_register;
  std::uint32_t fault_status;  ///< CFSR
  std::uint32_t bus_address;   ///< BFAR
  std::uint32_t reading;       ///< calibration slot, from 1, that is being read; 0: none is
  std::uint32_t unreadable;    ///< slots whose reading ended a run, a bit for each
};
inline constexpr std::uint32_t postmortem_magic = 0x504F5743;
extern Postmortem postmortem;
/// The same for the controller: crash, and whether the gate was on.
extern Survivor survivor;

/// Why the board started, one word. Reads and clears the flags: once a start.
std::string_view take_reset_cause();
/// The same as the controller knows it.
ResetCause reset_cause(std::string_view word);
CrashCause crash_cause(std::uint32_t exception);

/// Supply below some 2.9 V: the gate goes off in hardware, and an interrupt says so. To be called before set_up_gate(),
/// which locks the monitor's settings together with its way to the break input.
void start_supply_monitor();
bool supply_low();

/// Why the option bytes are not as this bench needs them; empty: they are. Needed are brown-out level 4, so that the
/// processor is in reset before the supply is too low for the converters, the parity check of the RAM, and a flash of
/// two banks, so that a calibration can be stored while the program runs.
std::string_view option_byte_error();

/// Reset after 100 ms without feed_watchdog(). From its own oscillator, and not to be stopped again.
void start_watchdog();
void feed_watchdog();

}  // namespace powbench::firmware::stm32g474
