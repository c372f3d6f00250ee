#pragma once

#include <cstddef>
#include <cstdint>

/// The binary interface of FMI 3.0 (Functional Mock-up Interface, version 3.0.1): types only. The functions are in
/// fmi3.cpp, exported by name.

namespace powbench::fmu::fmi3 {

using Pointer = void*;  ///< fmi3Instance
using Environment = void*;
using ValueReference = std::uint32_t;
using Boolean = bool;
using Text = const char*;  ///< fmi3String
using Byte = std::uint8_t;
using Binary = const Byte*;
using StateHandle = void*;  ///< fmi3FMUState

enum Status : int { ok, warning, discard, error, fatal };
enum DependencyKind : int { independent, constant, fixed, tunable, discrete, dependent };
enum IntervalQualifier : int { not_yet_known, unchanged, changed };

using Logger = void (*)(Environment, Status, Text category, Text message);
using ClockUpdate = void (*)(Environment);
using IntermediateUpdate = void (*)(Environment, double time, Boolean set_requested, Boolean get_allowed,
                                    Boolean step_finished, Boolean can_return_early,
                                    Boolean* early_return_requested, double* early_return_time);
using Preemption = void (*)();

}  // namespace powbench::fmu::fmi3
