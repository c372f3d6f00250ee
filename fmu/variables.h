#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/specimen/specimen.h"

/// The variables of the contactor as a functional mock-up unit, once: the model description and the access by value
/// reference derive from this table.

namespace powbench::fmu {

/// The two versions of the interface. 2: model exchange and co-simulation; 3: co-simulation.
enum class Fmi : std::uint8_t { two = 2, three = 3 };

struct Variable {
  enum class Kind : std::uint8_t {
    time,
    source_volts,
    source_hertz,
    source_phase,
    tolerance,
    number,  ///< of the specimen; index: in sim::specimen_fields()
    coil_voltage,
    coil_voltage_rate,
    coil_temperature,
    coil_closed,
    current,
    linkage,
    pull,
    travel,
    speed,
    stop_force,
    seated,
    seat_time,
    bridge_travel,  ///< index: pole
    force_a,
    force_b,
    closed,
    touch_time,
    state,  ///< index: of the state
    rate
  };
  enum class Causality : std::uint8_t { independent, parameter, input, output, local };

  std::uint32_t reference = 0;  ///< value reference, the place in the table
  Kind kind{};
  int index = 0;
  Causality causality{};
  std::string name, unit, description;
  double start = 0;      ///< of parameters and inputs
  bool boolean = false;  ///< else a real number
  bool discrete = false;
};

/// In the order of their value references.
std::vector<Variable> variables(const sim::Specimen&, Fmi);

/// A unit as powers of SI base units: value in SI = factor * value.
struct UnitRow {
  std::string name;
  int kg, m, s, A, K, rad;
  double factor;
};
/// Every unit that a variable can have.
const std::vector<UnitRow>& unit_rows();

}  // namespace powbench::fmu
