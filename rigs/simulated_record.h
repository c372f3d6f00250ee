#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/record.h"
#include "rigs/sim_rig_config.h"
#include "sim/models/closing.h"

namespace powbench::rigs {

/// A simulated closing as a record: plant alone, switched exactly at the commanded angle, through the virtual
/// sensor chain of the rig. What the sensors do to a signal (bandwidth, droop, delay, ringing, quantisation,
/// saturation) stands on both sides of a comparison; their noise and hum are left out, because a prediction
/// has none. The record holds the channels of `rig.sensors.channels`, each the same to the last bit whatever others
/// are wanted; none is refused with std::invalid_argument.
struct SimulatedClosing {
  Record record;
  sim::ClosingTruth truth;              ///< located by the integrator, unaffected by sensors
  std::vector<sim::PlantEvent> events;  ///< the same source, every event; s after switch-on
  std::int64_t evaluations = 0;         ///< of the right-hand side
  std::int64_t conversions = 0;         ///< values that the sensors made
  std::int64_t field_states = 0;        ///< as sim::Trajectory tells them; 0: the plant's own circuit
  std::int64_t field_beyond = 0;
};

SimulatedClosing simulate_record(const sim::Specimen&, const Conditions&, const SimRigConfig&);

/// One closing on any rung: specimen, conditions, s simulated, s between samples; switch-on at 0.
using ClosingRun = std::function<sim::Trajectory(const sim::Specimen&, const Conditions&, double duration,
                                                 double sample_dt)>;

/// The same record from another rung than the plant. `name` is kept with the record. A rung that ends early holds its
/// last state to the end of the record.
SimulatedClosing simulate_record_with(const ClosingRun&, const std::string& name, const sim::Specimen&,
                                      const Conditions&, const SimRigConfig&);

}  // namespace powbench::rigs
