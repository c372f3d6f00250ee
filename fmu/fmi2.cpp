#include "fmu/fmi2.h"

#include <algorithm>
#include <cstdarg>
#include <new>
#include <string>
#include <vector>

#include "fmu/instance.h"
#include "fmu/resource.h"

/// FMI 2.0: co-simulation and model exchange. Every function is refused with an error status where the state machine of
/// the standard does not allow it, where its instance is null or an array that is to be used is null.

namespace {

using namespace powbench::fmu;
using namespace powbench::fmu::fmi2;
using Mode = Instance::Mode;

struct Handle {
  Instance instance;
  std::string name;
  Callbacks callbacks;
  bool logging;
  std::vector<std::shared_ptr<const Instance::Saved>> saved;

  Status log(Status status, const char* text) const {
    if (logging && callbacks.logger != nullptr)
      callbacks.logger(callbacks.environment, name.c_str(), status, "logStatusError", "%s", text);
    return status;
  }
};

/// Runs `work` on the instance; what it throws becomes a status.
template <class Work>
Status run(Component c, std::initializer_list<Mode> modes, Work&& work) {
  if (c == nullptr) return error;
  auto& h = *static_cast<Handle*>(c);
  try {
    h.instance.require_mode(modes);
    work(h);
    return ok;
  } catch (const std::exception& e) {
    return h.log(error, e.what());
  } catch (...) {
    return h.log(fatal, "unknown failure");
  }
}

void require_arrays(std::size_t n, std::initializer_list<const void*> arrays) {
  if (n == 0) return;
  for (const void* a : arrays)
    if (a == nullptr) throw std::invalid_argument("an array is null");
}

void require_size(std::size_t n, int allowed) {
  if (n != static_cast<std::size_t>(allowed))
    throw std::invalid_argument("length " + std::to_string(n) + ", allowed " + std::to_string(allowed));
}

constexpr auto readable = {Mode::initialization, Mode::event, Mode::continuous, Mode::step, Mode::terminated};
constexpr auto writable = {Mode::instantiated, Mode::initialization, Mode::event, Mode::continuous,
                           Mode::step};
constexpr auto exchanging = {Mode::event, Mode::continuous};
constexpr auto any = {Mode::instantiated, Mode::initialization, Mode::event, Mode::continuous,
                      Mode::step,         Mode::terminated,     Mode::failed};
constexpr auto sound = {Mode::instantiated, Mode::initialization, Mode::event,
                        Mode::continuous,   Mode::step,           Mode::terminated};

Status unsupported(Component c) {
  return c == nullptr ? error
                      : static_cast<Handle*>(c)->log(error, "not offered, as the model description says");
}

/// The state handle of FMI is a pointer into the instance's own list.
const Instance::Saved& saved_of(const Handle& h, StateHandle state) {
  for (const auto& s : h.saved)
    if (s.get() == state) return *s;
  throw std::invalid_argument("a state of another instance, or one that was freed");
}

}  // namespace

#define POWBENCH_FMI extern "C" __attribute__((visibility("default")))

POWBENCH_FMI const char* fmi2GetTypesPlatform() {
  return "default";
}
POWBENCH_FMI const char* fmi2GetVersion() {
  return "2.0";
}

POWBENCH_FMI Component fmi2Instantiate(Text name, Type type, Text guid, Text location,
                                       const Callbacks* callbacks, Boolean, Boolean logging) {
  if (callbacks == nullptr) return nullptr;
  try {
    if (name == nullptr || *name == '\0') throw std::invalid_argument("an instance needs a name");
    if (guid == nullptr || location == nullptr)
      throw std::invalid_argument("GUID or resource location is null");
    if (type != model_exchange && type != co_simulation)
      throw std::invalid_argument("type of the FMU is not known");
    return new Handle{Instance(Fmi::two, type == model_exchange, folder_of_uri(location), guid),
                      name,
                      *callbacks,
                      logging != 0,
                      {}};
  } catch (const std::exception& e) {
    if (callbacks->logger != nullptr)
      callbacks->logger(callbacks->environment, name == nullptr ? "" : name, error, "logStatusError", "%s",
                        e.what());
    return nullptr;
  }
}

POWBENCH_FMI void fmi2FreeInstance(Component c) {
  delete static_cast<Handle*>(c);
}

POWBENCH_FMI Status fmi2SetDebugLogging(Component c, Boolean on, std::size_t n, const Text categories[]) {
  return run(c, any, [&](Handle& h) {
    require_arrays(n, {categories});
    for (std::size_t k = 0; k < n; ++k)
      if (categories[k] == nullptr || std::string(categories[k]) != "logStatusError")
        throw std::invalid_argument("log category is not known");
    h.logging = on != 0;
  });
}

POWBENCH_FMI Status fmi2SetupExperiment(Component c, Boolean, Real, Real start, Boolean stop_defined,
                                        Real stop) {
  return run(c, {Mode::instantiated}, [&](Handle& h) {
    h.instance.prepare(start, stop_defined != 0 ? std::optional(stop) : std::nullopt);
  });
}
POWBENCH_FMI Status fmi2EnterInitializationMode(Component c) {
  return run(c, {Mode::instantiated}, [](Handle& h) { h.instance.enter_initialization(); });
}
POWBENCH_FMI Status fmi2ExitInitializationMode(Component c) {
  return run(c, {Mode::initialization}, [](Handle& h) { h.instance.exit_initialization(); });
}
POWBENCH_FMI Status fmi2Terminate(Component c) {
  return run(c, {Mode::event, Mode::continuous, Mode::step, Mode::failed},
             [](Handle& h) { h.instance.terminate(); });
}
POWBENCH_FMI Status fmi2Reset(Component c) {
  return run(c, any, [](Handle& h) { h.instance.reset(); });
}

// --- variables ---

POWBENCH_FMI Status fmi2GetReal(Component c, const ValueReference vr[], std::size_t n, Real value[]) {
  return run(c, readable, [&](Handle& h) {
    require_arrays(n, {vr, value});
    for (std::size_t k = 0; k < n; ++k) value[k] = h.instance.number(vr[k]);
  });
}
POWBENCH_FMI Status fmi2SetReal(Component c, const ValueReference vr[], std::size_t n, const Real value[]) {
  return run(c, writable, [&](Handle& h) {
    require_arrays(n, {vr, value});
    for (std::size_t k = 0; k < n; ++k) h.instance.set_number(vr[k], value[k]);
  });
}
POWBENCH_FMI Status fmi2GetBoolean(Component c, const ValueReference vr[], std::size_t n, Boolean value[]) {
  return run(c, readable, [&](Handle& h) {
    require_arrays(n, {vr, value});
    for (std::size_t k = 0; k < n; ++k) value[k] = h.instance.flag(vr[k]) ? 1 : 0;
  });
}
POWBENCH_FMI Status fmi2SetBoolean(Component c, const ValueReference vr[], std::size_t n,
                                   const Boolean value[]) {
  return run(c, writable, [&](Handle& h) {
    require_arrays(n, {vr, value});
    for (std::size_t k = 0; k < n; ++k) h.instance.set_flag(vr[k], value[k] != 0);
  });
}
// The unit has no variables of these types: only an empty list is not refused.
POWBENCH_FMI Status fmi2GetInteger(Component c, const ValueReference*, std::size_t n, Integer*) {
  return n == 0 && c != nullptr ? ok : unsupported(c);
}
POWBENCH_FMI Status fmi2SetInteger(Component c, const ValueReference*, std::size_t n, const Integer*) {
  return n == 0 && c != nullptr ? ok : unsupported(c);
}
POWBENCH_FMI Status fmi2GetString(Component c, const ValueReference*, std::size_t n, Text*) {
  return n == 0 && c != nullptr ? ok : unsupported(c);
}
POWBENCH_FMI Status fmi2SetString(Component c, const ValueReference*, std::size_t n, const Text*) {
  return n == 0 && c != nullptr ? ok : unsupported(c);
}

// --- states of the whole unit ---

POWBENCH_FMI Status fmi2GetFMUstate(Component c, StateHandle* state) {
  return run(c, sound, [&](Handle& h) {
    require_arrays(1, {state});
    if (*state != nullptr) std::erase_if(h.saved, [&](const auto& s) { return s.get() == *state; });
    h.saved.push_back(h.instance.save());
    *state = const_cast<Instance::Saved*>(h.saved.back().get());
  });
}
POWBENCH_FMI Status fmi2SetFMUstate(Component c, StateHandle state) {
  return run(c, any, [&](Handle& h) { h.instance.go_back(saved_of(h, state)); });
}
POWBENCH_FMI Status fmi2FreeFMUstate(Component c, StateHandle* state) {
  return run(c, any, [&](Handle& h) {
    if (state == nullptr || *state == nullptr) return;
    saved_of(h, *state);
    std::erase_if(h.saved, [&](const auto& s) { return s.get() == *state; });
    *state = nullptr;
  });
}
POWBENCH_FMI Status fmi2SerializedFMUstateSize(Component c, StateHandle, std::size_t*) {
  return unsupported(c);
}
POWBENCH_FMI Status fmi2SerializeFMUstate(Component c, StateHandle, Byte*, std::size_t) {
  return unsupported(c);
}
POWBENCH_FMI Status fmi2DeSerializeFMUstate(Component c, const Byte*, std::size_t, StateHandle*) {
  return unsupported(c);
}
POWBENCH_FMI Status fmi2GetDirectionalDerivative(Component c, const ValueReference*, std::size_t,
                                                 const ValueReference*, std::size_t, const Real*, Real*) {
  return unsupported(c);
}

// --- co-simulation ---

POWBENCH_FMI Status fmi2SetRealInputDerivatives(Component c, const ValueReference vr[], std::size_t n,
                                                const Integer order[], const Real value[]) {
  return run(c, {Mode::instantiated, Mode::initialization, Mode::step}, [&](Handle& h) {
    require_arrays(n, {vr, order, value});
    for (std::size_t k = 0; k < n; ++k) h.instance.set_input_derivative(vr[k], order[k], value[k]);
  });
}
POWBENCH_FMI Status fmi2GetRealOutputDerivatives(Component c, const ValueReference*, std::size_t,
                                                 const Integer*, Real*) {
  return unsupported(c);
}
POWBENCH_FMI Status fmi2DoStep(Component c, Real t, Real h, Boolean) {
  return run(c, {Mode::step}, [&](Handle& handle) { handle.instance.step(t, h); });
}
POWBENCH_FMI Status fmi2CancelStep(Component c) {
  return unsupported(c);
}
// A step is over when it returns: only the time that was reached is worth asking for.
POWBENCH_FMI Status fmi2GetStatus(Component c, StatusKind, Status*) {
  return c == nullptr ? error : discard;
}
POWBENCH_FMI Status fmi2GetRealStatus(Component c, StatusKind kind, Real* value) {
  if (kind != last_successful_time) return c == nullptr ? error : discard;
  return run(c, {Mode::step, Mode::failed}, [&](Handle& h) {
    require_arrays(1, {value});
    *value = h.instance.number(0);
  });
}
POWBENCH_FMI Status fmi2GetIntegerStatus(Component c, StatusKind, Integer*) {
  return c == nullptr ? error : discard;
}
POWBENCH_FMI Status fmi2GetBooleanStatus(Component c, StatusKind kind, Boolean* value) {
  if (c == nullptr || value == nullptr) return error;
  if (kind != terminated) return discard;
  *value = 0;
  return ok;
}
POWBENCH_FMI Status fmi2GetStringStatus(Component c, StatusKind, Text*) {
  return c == nullptr ? error : discard;
}

// --- model exchange ---

POWBENCH_FMI Status fmi2EnterEventMode(Component c) {
  return run(c, exchanging, [](Handle& h) { h.instance.enter_event_mode(); });
}
POWBENCH_FMI Status fmi2NewDiscreteStates(Component c, EventInfo* info) {
  return run(c, {Mode::event}, [&](Handle& h) {
    require_arrays(1, {info});
    const auto u = h.instance.update();
    *info = {u.again ? 1 : 0, 0, 0, u.values_changed ? 1 : 0, 0, 0};
  });
}
POWBENCH_FMI Status fmi2EnterContinuousTimeMode(Component c) {
  return run(c, {Mode::event}, [](Handle& h) { h.instance.enter_continuous_mode(); });
}
POWBENCH_FMI Status fmi2CompletedIntegratorStep(Component c, Boolean, Boolean* enter_event_mode,
                                                Boolean* terminate) {
  return run(c, {Mode::continuous}, [&](Handle& h) {
    require_arrays(1, {enter_event_mode, terminate});
    *enter_event_mode = h.instance.driven().mode_ended() ? 1 : 0;
    *terminate = 0;
  });
}
POWBENCH_FMI Status fmi2SetTime(Component c, Real t) {
  return run(c, exchanging, [&](Handle& h) { h.instance.driven().set_time(t); });
}
POWBENCH_FMI Status fmi2SetContinuousStates(Component c, const Real x[], std::size_t n) {
  return run(c, {Mode::continuous}, [&](Handle& h) {
    auto& unit = h.instance.driven();
    require_size(n, unit.states());
    require_arrays(n, {x});
    unit.set_state({x, n});
  });
}
POWBENCH_FMI Status fmi2GetDerivatives(Component c, Real rates[], std::size_t n) {
  return run(c, {Mode::initialization, Mode::event, Mode::continuous, Mode::terminated}, [&](Handle& h) {
    auto& unit = h.instance.driven();
    require_size(n, unit.states());
    require_arrays(n, {rates});
    unit.derivatives({rates, n});
  });
}
POWBENCH_FMI Status fmi2GetEventIndicators(Component c, Real z[], std::size_t n) {
  return run(c, {Mode::initialization, Mode::event, Mode::continuous, Mode::terminated}, [&](Handle& h) {
    auto& unit = h.instance.driven();
    require_size(n, unit.indicators());
    require_arrays(n, {z});
    unit.indicate({z, n});
  });
}
POWBENCH_FMI Status fmi2GetContinuousStates(Component c, Real x[], std::size_t n) {
  return run(c, {Mode::initialization, Mode::event, Mode::continuous, Mode::terminated}, [&](Handle& h) {
    const auto& unit = h.instance.driven();
    require_size(n, unit.states());
    require_arrays(n, {x});
    std::copy_n(unit.state().begin(), n, x);
  });
}
POWBENCH_FMI Status fmi2GetNominalsOfContinuousStates(Component c, Real nominal[], std::size_t n) {
  return run(c, {Mode::initialization, Mode::event, Mode::continuous, Mode::terminated}, [&](Handle& h) {
    const auto& unit = h.instance.driven();
    require_size(n, unit.states());
    require_arrays(n, {nominal});
    for (std::size_t k = 0; k < n; ++k) nominal[k] = unit.nominal(static_cast<int>(k));
  });
}
