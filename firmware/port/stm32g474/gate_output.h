#pragma once

#include "firmware/port/common/gate_timer.h"

/// The pin that switches the coil: TIM1 channel 3 behind the timer's main output enable. That bit is off after reset;
/// exactly one line of this port sets it, and comparators, supply monitor, clock monitor and a locked-up core clear it
/// without any instruction.

namespace powbench::firmware::stm32g474 {

/// The pin low as a plain output: for the first instructions after a reset.
void hold_gate_low();

/// Timer, comparators, cut-off. The timer does not run yet; the gate is off.
void set_up_gate();

/// Writes what the gate timer decided. False when an on edge was refused because the cut-off is active.
bool write_gate(const port::GateTimer::Action& action);

/// Gate off now, by two stores.
void gate_off();

/// The cut-off has tripped since it was last asked, or its cause still stands.
bool cut_off_tripped();

/// Reading of the free-running timer.
std::uint16_t gate_counter();

/// The stop chain is open.
bool stop_open();

/// One step of the square wave that keeps the safety relay in; it drops when the steps stop.
void pump_safety_relay();

}  // namespace powbench::firmware::stm32g474
