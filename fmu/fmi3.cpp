#include "fmu/fmi3.h"

#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmu/instance.h"
#include "fmu/resource.h"

/// FMI 3.0: co-simulation with early return and event mode. Functions of what the unit does not offer are there and
/// refuse, as the standard demands.

namespace {

using namespace powbench::fmu;
using namespace powbench::fmu::fmi3;
using Mode = Instance::Mode;

struct Unit3 {
  Instance instance;
  Environment environment;
  Logger logger;
  bool logging;
  bool event_mode_used;
  std::vector<std::shared_ptr<const Instance::Saved>> saved;

  Status log(Status status, const char* text) const {
    if (logging && logger != nullptr) logger(environment, status, "logStatusError", text);
    return status;
  }
};

template <class Work>
Status perform(fmi3::Pointer c, std::initializer_list<Mode> modes, Work&& work) {
  if (c == nullptr) return error;
  auto& u = *static_cast<Unit3*>(c);
  try {
    u.instance.require_mode(modes);
    work(u);
    return ok;
  } catch (const std::exception& e) {
    return u.log(error, e.what());
  } catch (...) {
    return u.log(fatal, "unknown failure");
  }
}

Status not_offered(fmi3::Pointer c) {
  return c == nullptr ? error
                      : static_cast<Unit3*>(c)->log(error, "not offered, as the model description says");
}

void require_same(std::size_t n, std::size_t values, const void* a, const void* b) {
  if (n != values)
    throw std::invalid_argument("as many values as value references are needed: all are scalars");
  if (n > 0 && (a == nullptr || b == nullptr)) throw std::invalid_argument("an array is null");
}

const Instance::Saved& saved_in(const Unit3& u, StateHandle state) {
  for (const auto& s : u.saved)
    if (s.get() == state) return *s;
  throw std::invalid_argument("a state of another instance, or one that was freed");
}

constexpr auto can_get = {Mode::initialization, Mode::event, Mode::step, Mode::terminated};
constexpr auto can_set = {Mode::instantiated, Mode::initialization, Mode::event, Mode::step};
constexpr auto all_modes = {Mode::instantiated, Mode::initialization, Mode::event,
                            Mode::step,         Mode::terminated,     Mode::failed};

}  // namespace

#define POWBENCH_FMI extern "C" __attribute__((visibility("default")))
#define POWBENCH_REFS const ValueReference *vr, std::size_t n

POWBENCH_FMI const char* fmi3GetVersion() {
  return "3.0";
}

POWBENCH_FMI fmi3::Pointer fmi3InstantiateCoSimulation(Text name, Text token, Text folder, Boolean,
                                                       Boolean logging, Boolean event_mode_used,
                                                       Boolean early_return_allowed, const ValueReference*,
                                                       std::size_t intermediate, Environment environment,
                                                       Logger logger, IntermediateUpdate) {
  try {
    if (name == nullptr || *name == '\0') throw std::invalid_argument("an instance needs a name");
    if (token == nullptr || folder == nullptr) throw std::invalid_argument("token or resource path is null");
    if (intermediate > 0) throw std::invalid_argument("intermediate update is not offered");
    auto* u = new Unit3{
        Instance(Fmi::three, false, folder, token), environment, logger, logging, event_mode_used, {}};
    u->instance.use_event_mode(event_mode_used, early_return_allowed);
    return u;
  } catch (const std::exception& e) {
    if (logger != nullptr) logger(environment, error, "logStatusError", e.what());
    return nullptr;
  }
}
POWBENCH_FMI fmi3::Pointer fmi3InstantiateModelExchange(Text, Text, Text, Boolean, Boolean,
                                                        Environment environment, Logger logger) {
  if (logger != nullptr)
    logger(environment, error, "logStatusError", "co-simulation only; model exchange by FMI 2.0");
  return nullptr;
}
POWBENCH_FMI fmi3::Pointer fmi3InstantiateScheduledExecution(Text, Text, Text, Boolean, Boolean,
                                                             Environment environment, Logger logger,
                                                             ClockUpdate, Preemption, Preemption) {
  if (logger != nullptr) logger(environment, error, "logStatusError", "co-simulation only");
  return nullptr;
}
POWBENCH_FMI void fmi3FreeInstance(fmi3::Pointer c) {
  delete static_cast<Unit3*>(c);
}

POWBENCH_FMI Status fmi3SetDebugLogging(fmi3::Pointer c, Boolean on, std::size_t n, const Text* categories) {
  return perform(c, all_modes, [&](Unit3& u) {
    for (std::size_t k = 0; k < n; ++k)
      if (categories == nullptr || categories[k] == nullptr || std::string(categories[k]) != "logStatusError")
        throw std::invalid_argument("log category is not known");
    u.logging = on;
  });
}

POWBENCH_FMI Status fmi3EnterInitializationMode(fmi3::Pointer c, Boolean, double, double start,
                                                Boolean stop_defined, double stop) {
  return perform(c, {Mode::instantiated}, [&](Unit3& u) {
    u.instance.prepare(start, stop_defined ? std::optional(stop) : std::nullopt);
    u.instance.enter_initialization();
  });
}
POWBENCH_FMI Status fmi3ExitInitializationMode(fmi3::Pointer c) {
  return perform(c, {Mode::initialization}, [](Unit3& u) { u.instance.exit_initialization(); });
}
POWBENCH_FMI Status fmi3EnterEventMode(fmi3::Pointer c) {
  return perform(c, {Mode::step}, [](Unit3& u) {
    if (!u.event_mode_used) throw std::invalid_argument("instantiated without event mode");
    u.instance.enter_event_mode();
  });
}
POWBENCH_FMI Status fmi3EnterStepMode(fmi3::Pointer c) {
  return perform(c, {Mode::event}, [](Unit3& u) { u.instance.enter_step_mode(); });
}
POWBENCH_FMI Status fmi3Terminate(fmi3::Pointer c) {
  return perform(c, {Mode::event, Mode::step, Mode::failed}, [](Unit3& u) { u.instance.terminate(); });
}
POWBENCH_FMI Status fmi3Reset(fmi3::Pointer c) {
  return perform(c, all_modes, [](Unit3& u) { u.instance.reset(); });
}

POWBENCH_FMI Status fmi3DoStep(fmi3::Pointer c, double t, double h, Boolean, Boolean* event_needed,
                               Boolean* terminate, Boolean* early, double* reached) {
  return perform(c, {Mode::step}, [&](Unit3& u) {
    if (event_needed == nullptr || terminate == nullptr || early == nullptr || reached == nullptr)
      throw std::invalid_argument("a place for a result is null");
    const auto s = u.instance.step(t, h);
    *event_needed = s.event;
    *terminate = false;
    *early = s.early;
    *reached = s.reached;
  });
}
POWBENCH_FMI Status fmi3EvaluateDiscreteStates(fmi3::Pointer c) {
  return perform(c, {Mode::initialization, Mode::event}, [](Unit3&) {});
}
POWBENCH_FMI Status fmi3UpdateDiscreteStates(fmi3::Pointer c, Boolean* again, Boolean* terminate,
                                             Boolean* nominals, Boolean* values, Boolean* time_defined,
                                             double* time) {
  return perform(c, {Mode::event}, [&](Unit3& u) {
    for (const void* place : {static_cast<const void*>(again), static_cast<const void*>(terminate),
                              static_cast<const void*>(nominals), static_cast<const void*>(values),
                              static_cast<const void*>(time_defined), static_cast<const void*>(time)})
      if (place == nullptr) throw std::invalid_argument("a place for a result is null");
    u.instance.update();
    *again = *terminate = *nominals = *values = *time_defined = false;
    *time = 0;
  });
}

// --- variables ---

POWBENCH_FMI Status fmi3GetFloat64(fmi3::Pointer c, POWBENCH_REFS, double* values, std::size_t count) {
  return perform(c, can_get, [&](Unit3& u) {
    require_same(n, count, vr, values);
    for (std::size_t k = 0; k < n; ++k) values[k] = u.instance.number(vr[k]);
  });
}
POWBENCH_FMI Status fmi3SetFloat64(fmi3::Pointer c, POWBENCH_REFS, const double* values, std::size_t count) {
  return perform(c, can_set, [&](Unit3& u) {
    require_same(n, count, vr, values);
    for (std::size_t k = 0; k < n; ++k) u.instance.set_number(vr[k], values[k]);
  });
}
POWBENCH_FMI Status fmi3GetBoolean(fmi3::Pointer c, POWBENCH_REFS, Boolean* values, std::size_t count) {
  return perform(c, can_get, [&](Unit3& u) {
    require_same(n, count, vr, values);
    for (std::size_t k = 0; k < n; ++k) values[k] = u.instance.flag(vr[k]);
  });
}
POWBENCH_FMI Status fmi3SetBoolean(fmi3::Pointer c, POWBENCH_REFS, const Boolean* values, std::size_t count) {
  return perform(c, can_set, [&](Unit3& u) {
    require_same(n, count, vr, values);
    for (std::size_t k = 0; k < n; ++k) u.instance.set_flag(vr[k], values[k]);
  });
}

// The unit has no variables of these types: only an empty list is not refused.
#define POWBENCH_NO_VARIABLES(type, value)                                                               \
  POWBENCH_FMI Status fmi3Get##type(fmi3::Pointer c, const ValueReference*, std::size_t n, value*,       \
                                    std::size_t) {                                                       \
    return n == 0 && c != nullptr ? ok : not_offered(c);                                                 \
  }                                                                                                      \
  POWBENCH_FMI Status fmi3Set##type(fmi3::Pointer c, const ValueReference*, std::size_t n, const value*, \
                                    std::size_t) {                                                       \
    return n == 0 && c != nullptr ? ok : not_offered(c);                                                 \
  }
POWBENCH_NO_VARIABLES(Float32, float)
POWBENCH_NO_VARIABLES(Int8, std::int8_t)
POWBENCH_NO_VARIABLES(UInt8, std::uint8_t)
POWBENCH_NO_VARIABLES(Int16, std::int16_t)
POWBENCH_NO_VARIABLES(UInt16, std::uint16_t)
POWBENCH_NO_VARIABLES(Int32, std::int32_t)
POWBENCH_NO_VARIABLES(UInt32, std::uint32_t)
POWBENCH_NO_VARIABLES(Int64, std::int64_t)
POWBENCH_NO_VARIABLES(UInt64, std::uint64_t)
POWBENCH_NO_VARIABLES(String, Text)

// --- states of the whole unit ---

POWBENCH_FMI Status fmi3GetFMUState(fmi3::Pointer c, StateHandle* state) {
  return perform(c, {Mode::instantiated, Mode::initialization, Mode::event, Mode::step, Mode::terminated},
                 [&](Unit3& u) {
                   if (state == nullptr) throw std::invalid_argument("a place for a result is null");
                   std::erase_if(u.saved, [&](const auto& s) { return s.get() == *state; });
                   u.saved.push_back(u.instance.save());
                   *state = const_cast<Instance::Saved*>(u.saved.back().get());
                 });
}
POWBENCH_FMI Status fmi3SetFMUState(fmi3::Pointer c, StateHandle state) {
  return perform(c, all_modes, [&](Unit3& u) { u.instance.go_back(saved_in(u, state)); });
}
POWBENCH_FMI Status fmi3FreeFMUState(fmi3::Pointer c, StateHandle* state) {
  return perform(c, all_modes, [&](Unit3& u) {
    if (state == nullptr || *state == nullptr) return;
    saved_in(u, *state);
    std::erase_if(u.saved, [&](const auto& s) { return s.get() == *state; });
    *state = nullptr;
  });
}

// --- not offered ---

#define POWBENCH_NOT_OFFERED(name, ...)                                  \
  POWBENCH_FMI Status name(fmi3::Pointer c __VA_OPT__(, ) __VA_ARGS__) { \
    return not_offered(c);                                               \
  }
POWBENCH_NOT_OFFERED(fmi3GetBinary, const ValueReference*, std::size_t, std::size_t*, Binary*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3SetBinary, const ValueReference*, std::size_t, const std::size_t*, const Binary*,
                     std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetClock, const ValueReference*, std::size_t, Boolean*)
POWBENCH_NOT_OFFERED(fmi3SetClock, const ValueReference*, std::size_t, const Boolean*)
POWBENCH_NOT_OFFERED(fmi3GetNumberOfVariableDependencies, ValueReference, std::size_t*)
POWBENCH_NOT_OFFERED(fmi3GetVariableDependencies, ValueReference, std::size_t*, ValueReference*, std::size_t*,
                     DependencyKind*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3SerializedFMUStateSize, StateHandle, std::size_t*)
POWBENCH_NOT_OFFERED(fmi3SerializeFMUState, StateHandle, Byte*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3DeserializeFMUState, const Byte*, std::size_t, StateHandle*)
POWBENCH_NOT_OFFERED(fmi3GetDirectionalDerivative, const ValueReference*, std::size_t, const ValueReference*,
                     std::size_t, const double*, std::size_t, double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetAdjointDerivative, const ValueReference*, std::size_t, const ValueReference*,
                     std::size_t, const double*, std::size_t, double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3EnterConfigurationMode)
POWBENCH_NOT_OFFERED(fmi3ExitConfigurationMode)
POWBENCH_NOT_OFFERED(fmi3GetIntervalDecimal, const ValueReference*, std::size_t, double*, IntervalQualifier*)
POWBENCH_NOT_OFFERED(fmi3GetIntervalFraction, const ValueReference*, std::size_t, std::uint64_t*,
                     std::uint64_t*, IntervalQualifier*)
POWBENCH_NOT_OFFERED(fmi3GetShiftDecimal, const ValueReference*, std::size_t, double*)
POWBENCH_NOT_OFFERED(fmi3GetShiftFraction, const ValueReference*, std::size_t, std::uint64_t*, std::uint64_t*)
POWBENCH_NOT_OFFERED(fmi3SetIntervalDecimal, const ValueReference*, std::size_t, const double*)
POWBENCH_NOT_OFFERED(fmi3SetIntervalFraction, const ValueReference*, std::size_t, const std::uint64_t*,
                     const std::uint64_t*)
POWBENCH_NOT_OFFERED(fmi3SetShiftDecimal, const ValueReference*, std::size_t, const double*)
POWBENCH_NOT_OFFERED(fmi3SetShiftFraction, const ValueReference*, std::size_t, const std::uint64_t*,
                     const std::uint64_t*)
POWBENCH_NOT_OFFERED(fmi3EnterContinuousTimeMode)
POWBENCH_NOT_OFFERED(fmi3CompletedIntegratorStep, Boolean, Boolean*, Boolean*)
POWBENCH_NOT_OFFERED(fmi3SetTime, double)
POWBENCH_NOT_OFFERED(fmi3SetContinuousStates, const double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetContinuousStateDerivatives, double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetEventIndicators, double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetContinuousStates, double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetNominalsOfContinuousStates, double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3GetNumberOfEventIndicators, std::size_t*)
POWBENCH_NOT_OFFERED(fmi3GetNumberOfContinuousStates, std::size_t*)
POWBENCH_NOT_OFFERED(fmi3GetOutputDerivatives, const ValueReference*, std::size_t, const std::int32_t*,
                     double*, std::size_t)
POWBENCH_NOT_OFFERED(fmi3ActivateModelPartition, ValueReference, double)
