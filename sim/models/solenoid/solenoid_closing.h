#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "sim/models/solenoid/solenoid_model.h"

/// One closing of a solenoid, and on wish its opening.

namespace powbench::sim {

struct SolenoidCase {
  Supply supply;
  double coil_kelvin = 293.15;  ///< K
  double hold =
      std::numeric_limits<double>::infinity();  ///< s: the coil is switched off here; infinity: never
  double duration = 60e-3;                      ///< s, of the simulation
  double sample_step = 100e-6;                  ///< s
  double tolerance = 1e-8;                      ///< of the integrator, per state
};

/// Times in s from the command at t = 0. Empty: it does not happen.
struct SolenoidTruth {
  std::optional<double> start;  ///< the plunger leaves the open stop
  std::optional<double> seat;   ///< it first touches the closed stop: the pull-in time
  std::optional<double>
      settled;               ///< its last touch before the coil is switched off; it stays closed from then on
  double seat_velocity = 0;  ///< m/s
  double peak_current = 0;   ///< A, before the dip that the moving plunger makes
  std::optional<double> peak_at, dip_at;
  double dip_current = 0;        ///< A, lowest between peak and a millisecond after the first touch
  double last_current = 0;       ///< A, at the end or when the coil is switched off
  std::optional<double> unseat;  ///< after the coil is off the plunger leaves the closed stop for good
  std::optional<double> back;    ///< and first touches the open stop
};

struct SolenoidRun {
  std::vector<SolenoidSample> samples;
  std::vector<SolenoidEvent> events;
  SolenoidTruth truth;
  double energy_residual = 0;
  double supplied = 0;                  ///< J
  std::int64_t states = 0, beyond = 0;  ///< of the potential: asked, and outside of what it was made from
};

/// Finds peak and dip in the samples of a run that has closed: the last peak of the current before the plunger
/// arrives, and the lowest current until a millisecond after, no later than `off`, s.
void find_current_dip(const SolenoidRun&, double off, SolenoidTruth&);

/// Throws std::invalid_argument for a bad specimen, supply or case, std::runtime_error where the integration fails.
SolenoidRun simulate_solenoid(const SolenoidSpecimen&, const MagneticPotential&, const SolenoidCase&);

}  // namespace powbench::sim
