#pragma once

#include "firmware/port/common/gate_timer.h"

/// The pin that switches the coil: TIM1 channel 3 behind the timer's main output enable. That bit is off after reset;
/// exactly one line of this port sets it, and comparators, supply monitor, clock monitor and a locked-up core clear it
/// without any instruction.

namespace powbench::firmware::stm32g474 {

/// The pin low as a plain output: for the first instructions after a reset.
extern "C" void hold_gate_low();

/// Timer, comparators, cut-off. The timer does not run yet; the gate is off.
void set_up_gate();

/// Writes what the gate timer decided. False when an on edge was refused because the cut-off is active.
bool write_gate(const port::GateTimer::Action& action);

/// Gate off now. From any level.
void gate_off();
/// The output enable is set: the gate is on, or a compare may switch it on.
bool gate_open();

/// What takes the gate off from an interrupt, at once: the stop chain and the supply monitor. It stays refused until
/// forget_cut(), so that no edge that the controller has planned before can open it again.
enum class Cut : std::uint8_t { stop = 1, supply = 2 };
void cut_gate(Cut);
bool cut_by(Cut);
/// The controller knows.
void forget_cut();

/// The cut-off has tripped since it was last asked, or its cause still stands.
bool cut_off_tripped();

/// The interrupts of stop chain and supply monitor, from here on.
void enable_cuts();

/// Reading of the free-running timer.
std::uint16_t gate_counter();

/// The stop chain is open.
bool stop_open();
/// The safety relay is closed, or the wire of its read-back contact broken: that contact is closed while the relay is
/// out.
bool relay_in();

/// One step of the square wave that keeps the safety relay in; it drops when the steps stop.
void pump_safety_relay();

}  // namespace powbench::firmware::stm32g474
