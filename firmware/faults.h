#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// The twenty-two faults of the bench, in one table: detection, reaction, time limit, and the message to the user.
/// Enumeration, texts and latching derive from this table; docs/reference/faults.md is compared with it by a test.
/// Columns: number | name | reaction | limit in us from the cause | when it is watched | what clears it |
///          detection | reason (what happened and what to do)
#define POWBENCH_FAULTS(X)                                                                                   \
  X(1, mains_lost, gate_off, 20'000, shot, acknowledge, "mains below 0.2 of nominal for 1.5 half-cycles",    \
    "mains lost: check the supply, then write 1 to abort")                                                   \
  X(2, phase_invalid, withhold, 20'000, shot, acknowledge,                                                   \
    "a fault of the mains, or three u of the phase at the closing angle beyond its tolerance; 1 s after "    \
    "fire",                                                                                                  \
    "mains phase not valid for 1 s: see phase_faults, then write 1 to abort")                                \
  X(3, coil_overcurrent, gate_off, 120, shot, acknowledge,                                                   \
    "two samples above the trip level, or the comparator that cuts the gate by itself",                      \
    "coil current above the trip level: check the coil, then write 1 to abort")                              \
  X(4, coil_stuck_on, open_relay, 26'000, always, cause_gone, "gate off and coil current for 25 ms",         \
    "coil current flows with the gate off: switch the supply off and replace the coil switch")               \
  X(5, coil_not_energising, gate_off, 5'000, shot, acknowledge, "gate on and no coil current for 4.8 ms",    \
    "no coil current after the gate: check the coil circuit, then write 1 to abort")                         \
  X(6, on_time_exceeded, gate_off, 100, shot, acknowledge,                                                   \
    "the off edge goes to the timer together with the on edge; a block found behind it",                     \
    "the samples stopped until after the end of the hold time: the timer opened, write 1 to abort")          \
  X(7, samples_lost, gate_off, 120, shot, acknowledge,                                                       \
    "overrun flag, block counter, jump of the sample index, block of equal samples or equal to the last",    \
    "converter samples were lost: the record is void, write 1 to abort and fire again")                      \
  X(8, host_lost, gate_off, 250'200, shot, acknowledge, "energised and no word from the owner for 250 ms",   \
    "the owner was silent for 250 ms while the coil was on: check the cable, then write 1 to abort")         \
  X(9, brown_out, gate_off, 120, always, cause_gone, "the supply monitor's warning flag",                    \
    "the board's supply sags: check its power supply, then write 1 to abort")                                \
  X(10, watchdog_reset, gate_off, 110'000, boot, acknowledge,                                                \
    "watchdog fed only when interrupts, main loop and communication have all moved on",                      \
    "the watchdog has reset the board: please report it with last_reset, then write 1 to abort")             \
  X(11, crash_reset, gate_off, 10, boot, acknowledge,                                                        \
    "the processor's fault handlers, in RAM kept at reset",                                                  \
    "the firmware has crashed and restarted: please report it with last_reset, then write 1 to abort")       \
  X(12, emergency_stop, gate_off, 120, shot, cause_gone, "the emergency stop's chain is open",               \
    "emergency stop is open: close it, then write 1 to abort")                                               \
  X(13, bad_parameter, refuse, 0, command, nothing, "every value against its range; not a number is EINVAL", \
    "value refused: see the attribute's _available for its range")                                           \
  X(14, double_fire, refuse, 0, command, nothing,                                                            \
    "one-shot token, contact proven open, pause between shots, shots a minute, share of time energised",     \
    "command refused: one arm gives one fire, and a shot has to be over before the next one")                \
  X(15, deadline_missed, next_crossing, 0, shot, nothing, "the planned edge lies behind the clock",          \
    "gate edge came too late for its crossing: the next one is taken")                                       \
  X(16, reset_while_energised, gate_off, 10, boot, acknowledge,                                              \
    "word in RAM kept at reset says on, or coil current in the first block after boot",                      \
    "restart with coil current: check supply and current zero, then write 1 to abort")                       \
  X(17, sensor_implausible, mark_record, 6'000, shot, acknowledge,                                           \
    "laser out of range or contact against travel for 5 ms; a saturated force sample",                       \
    "laser or contact signal is implausible: check the sensors, then write 1 to abort")                      \
  X(18, config_corrupt, gate_off, 12'000, always, cause_gone,                                                \
    "stored CRC at start, rolling CRC of the configuration in RAM; clock failure flag",                      \
    "clock or stored configuration is damaged: write the calibration again and restart")                     \
  X(19, contact_welded, open_relay, 102'000, always, cause_gone,                                             \
    "contact closed 100 ms after the gate opened, coil without current",                                     \
    "contact is still closed 100 ms after switch-off: it may be welded, inspect the contactor")              \
  X(20, phase_stale, gate_off, 2'200, shot, acknowledge, "phase estimate older than 2 ms",                   \
    "the phase estimate is not renewed in time: the controller is overloaded, write 1 to abort")             \
  X(21, relay_welded, gate_off, 100'200, always, cause_gone,                                                 \
    "relay told to open, read back closed for 100 ms",                                                       \
    "the safety relay does not open: switch the supply off and replace it, or mend the wire that reads it "  \
    "back")                                                                                                  \
  X(22, relay_open, gate_off, 100'200, shot, acknowledge, "relay told to close, read back open for 100 ms",  \
    "the safety relay does not close: check its supply and the stop chain, then write 1 to abort")

namespace powbench::firmware {

enum class Fault : std::uint8_t {
  none = 0,
#define POWBENCH_X(number, name, ...) name = number,
  POWBENCH_FAULTS(POWBENCH_X)
#undef POWBENCH_X
};

/// What the core does about it, for the page and the tests: FireControl::trip opens gate and relay for every fault that
/// latches, what differs is in FireControl::examine and schedule.
enum class Reaction : std::uint8_t {
  gate_off,       ///< coil off
  open_relay,     ///< coil off and the safety relay, which cuts the coil's supply, open
  withhold,       ///< no edge while it lasts, latched after 1 s; an energised coil stays: its edge is past
  refuse,         ///< the command has no effect
  next_crossing,  ///< never a late edge: the shot waits for the next crossing
  mark_record,    ///< before the edge like gate_off; after it the record is marked and the shot goes on
};

/// When it is looked for.
enum class Watch : std::uint8_t {
  shot,     ///< armed, waiting for the edge, energised
  always,   ///< in every state
  command,  ///< at each command
  boot,     ///< once after a reset
};

/// What ends it. A latched fault waits for `abort` with the gate off.
enum class Clears : std::uint8_t {
  nothing,      ///< does not latch
  acknowledge,  ///< `abort`; a cause that is still there is found again before the gate can open
  cause_gone,   ///< `abort`, refused while the cause is there
};

struct FaultInfo {
  Fault fault;
  std::string_view name;
  Reaction reaction;
  std::int32_t limit_us;
  Watch watch;
  Clears clears;
  std::string_view detection;
  std::string_view reason;
};

inline constexpr std::array fault_table{
#define POWBENCH_X(number, name, reaction, limit, watch, clears, detection, reason) \
  FaultInfo{Fault::name, #name, Reaction::reaction, limit, Watch::watch, Clears::clears, detection, reason},
    POWBENCH_FAULTS(POWBENCH_X)
#undef POWBENCH_X
};
static_assert(fault_table.size() == 22);

/// The row of a fault other than none.
constexpr const FaultInfo& info(Fault fault) {
  return fault_table[static_cast<std::size_t>(fault) - 1];
}

/// One sentence: what happened and what to do.
constexpr std::string_view reason(Fault fault) {
  return fault == Fault::none ? std::string_view("no fault") : info(fault).reason;
}

}  // namespace powbench::firmware
