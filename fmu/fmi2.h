#pragma once

#include <cstddef>

/// The binary interface of FMI 2.0 (Functional Mock-up Interface, version 2.0.4): types only. The functions are in
/// fmi2.cpp, exported by name.

namespace powbench::fmu::fmi2 {

using Component = void*;
using Environment = void*;
using ValueReference = unsigned int;
using Real = double;
using Integer = int;
using Boolean = int;
using Text = const char*;  ///< fmi2String
using Byte = char;
using StateHandle = void*;  ///< fmi2FMUstate

enum Status : int { ok, warning, discard, error, fatal, pending };
enum Type : int { model_exchange, co_simulation };
enum StatusKind : int { do_step_status, pending_status, last_successful_time, terminated };

using Logger = void (*)(Environment, Text instance, Status, Text category, Text message, ...);

struct Callbacks {
  Logger logger;
  void* (*allocate)(std::size_t count, std::size_t size);
  void (*release)(void*);
  void (*step_finished)(Environment, Status);
  Environment environment;
};

struct EventInfo {
  Boolean new_discrete_states_needed;
  Boolean terminate_simulation;
  Boolean nominals_changed;
  Boolean values_changed;
  Boolean next_event_time_defined;
  Real next_event_time;
};

}  // namespace powbench::fmu::fmi2
