#pragma once

namespace powbench::firmware::stm32g474 {

/// Core and buses to 170 MHz from the board's 24 MHz crystal. False when the crystal does not start: the internal
/// oscillator (1 %) then takes its place, good enough to answer but not to fire.
bool start_clock();

}  // namespace powbench::firmware::stm32g474
