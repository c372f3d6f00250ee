#pragma once

#include <cstdint>

/// What the emulator's exit status says about the image.

namespace powbench::firmware {

inline constexpr std::uint32_t exit_end_of_plant = 0;      ///< the plant closed the line: a normal end
inline constexpr std::uint32_t exit_refused = 3;           ///< a frame was refused; the refusal says why
inline constexpr std::uint32_t exit_no_line = 4;           ///< the line to the plant could not be opened
inline constexpr std::uint32_t exit_processor_fault = 98;  ///< HardFault or another unexpected exception

}  // namespace powbench::firmware
