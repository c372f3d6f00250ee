#pragma once

#include <array>
#include <cstdint>

#include "firmware/port/common/gate_timer.h"
#include "firmware/port/common/scan_queue.h"

/// The board as figures: clock, pins, converters, memory. docs/how-to/board.md explains them.

namespace powbench::firmware::stm32g474 {

inline constexpr std::uint32_t core_hertz = 170'000'000;
inline constexpr std::uint32_t sample_rate = 100'000;  ///< Hz, all channels
inline constexpr std::uint32_t baud = 2'000'000;

inline constexpr std::int64_t block_samples = 10;  ///< half of a converter's buffer
inline constexpr std::size_t queue_blocks = 8;
/// An edge is fixed this long before it is made: two blocks. The longest control step takes some 2000 instructions,
/// 18 us at
/// 1.5 cycles each; then the edge has to be in the compare register.
inline constexpr std::int64_t lead_samples = 20;

inline constexpr std::int64_t record_length = 6100;  ///< scans: 61 ms, 97 600 B
inline constexpr std::int64_t pretrigger = 2000;     ///< scans: one mains cycle at 50 Hz

inline constexpr port::TimeBase time_base{.ticks_per_sample = core_hertz / sample_rate,
                                          .first_trigger = core_hertz / sample_rate};
static_assert(core_hertz % sample_rate == 0 && core_hertz % baud == 0);
// a step may take three blocks: an edge that was too far for the compare at one poll is not too near at the next
static_assert(port::GateTimer::horizon - port::GateTimer::margin >
              3 * block_samples * time_base.ticks_per_sample);

// the end of the hold time is held by a 32-bit count
static_assert(std::int64_t{11} * core_hertz < (std::int64_t{1} << 32));

inline constexpr std::uintptr_t flash_start = 0x0800'0000;
// the calibration's slots: pages of 2 KiB at the end of the second bank
inline constexpr std::uint32_t slot_page[] = {126, 127};
inline constexpr std::uintptr_t slot_address[] = {0x0807'F000, 0x0807'F800};

// ---- memory with parity bits: the first 32 KiB, and the alias of the CCM RAM at the end ----

inline constexpr std::uint32_t parity_low_end = 0x2000'8000, parity_high = 0x2001'8000, ram_end = 0x2002'0000;

// ---- pins ----

inline constexpr unsigned pin_gate = 10;  ///< PA10: TIM1 channel 3, alternate function 6; pulled down outside
inline constexpr unsigned pin_lamp = 5;   ///< PA5: the board's green lamp, gate on
inline constexpr unsigned pin_serial_tx = 2;  ///< PA2, alternate function 7, to the virtual serial port
inline constexpr unsigned pin_serial_rx = 3;  ///< PA3
inline constexpr unsigned pin_relay = 12;     ///< PC12: closed to ground = relay out, open = relay in
inline constexpr unsigned pin_stop = 10;      ///< PC10: closed to ground = ready, open = stop
inline constexpr unsigned pin_charge_pump =
    11;  ///< PC11: toggles while the control step lives and sees no fault
inline constexpr std::uint32_t function_tim1 = 6, function_usart2 = 7;

// ---- converters ----

inline constexpr std::size_t converters = 5;
/// Inputs of converter 1 .. 5 in the order of conversion.
struct Sequence {
  std::uint8_t inputs[2];
  std::uint8_t ranks;
};
inline constexpr std::array<Sequence, converters> sequences{{
    {{6, 0}, 1},   // PC0
    {{7, 0}, 1},   // PC1
    {{12, 5}, 2},  // PB0, PB13
    {{4, 5}, 2},   // PB14, PB15
    {{1, 2}, 2},   // PA8, PA9
}};
/// Samples in a value: a single input is taken 16 times (16 bits), one of two 8 times (15 bits).
inline constexpr port::ChannelSources channel_sources{{
    {.converter = 0, .rank = 0, .shift = 0, .bipolar = true},   // pvdf_a
    {.converter = 1, .rank = 0, .shift = 0, .bipolar = true},   // pvdf_b
    {.converter = 4, .rank = 0, .shift = 1, .bipolar = false},  // laser
    {.converter = 2, .rank = 0, .shift = 1, .bipolar = true},   // coil_current
    {.converter = 3, .rank = 0, .shift = 1, .bipolar = true},   // coil_voltage
    {.converter = 3, .rank = 1, .shift = 1, .bipolar = true},   // mains_voltage
    {.converter = 4, .rank = 1, .shift = 1, .bipolar = false},  // contact_a
    {.converter = 2, .rank = 1, .shift = 1, .bipolar = true},   // aux
}};

inline constexpr double converter_hertz =
    core_hertz / 4.0;  ///< 42.5 MHz; 52 MHz is the limit with several at work
inline constexpr double conversion_cycles = 6.5 + 12.5;
/// Time from the trigger to the centre of a value's samples: `rank` values of 16 / ranks samples come before it.
constexpr double burst_centre(std::size_t converter, unsigned rank) {
  const double taken = 16.0 / sequences[converter].ranks;
  return ((rank * taken + (taken - 1) / 2) * conversion_cycles + 6.5) / converter_hertz;
}
static_assert(16 * conversion_cycles / converter_hertz < 0.8 / sample_rate);

}  // namespace powbench::firmware::stm32g474
