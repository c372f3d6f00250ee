#pragma once

#include "core/conditions.h"
#include "sim/models/closing.h"

/// The voltages at which a contactor picks up and drops out.

namespace powbench::sim {

struct VoltageOptions {
  int angles = 8;             ///< closing angles tried, over half a mains period
  double wait = 0.2;          ///< s after switch-on, or after the voltage has fallen, until it is looked at
  double resolution = 0.002;  ///< of conditions.supply_volts
  double tolerance = 1e-6;    ///< of the integrator
};

/// Closed is who has been so for two mains periods: a pole that touches and opens again with the pull is not.
bool stays_closed(const ClosingTruth&, const Conditions&);

/// Lowest voltage, V rms, above which it closes and stays closed at every angle tried, found by halving between 0 and
/// conditions.supply_volts. Throws std::invalid_argument where it does not close at that.
double pick_up_volts(const Specimen&, const Conditions&, const VoltageOptions& = {});

/// Closed at conditions.supply_volts and held there for `wait`; then the voltage falls: highest voltage at which it
/// has not stayed closed for `wait` more, by halving. Throws as above.
double drop_out_volts(const Specimen&, const Conditions&, const VoltageOptions& = {});

}  // namespace powbench::sim
