#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "sim/specimen/specimen.h"
#include "sim/supply/supply_modes.h"

/// The contactor as a dynamic system in virtual time: switch the coil, advance, read samples.
/// The simulated rig steps it in lock-step with the firmware; `sim/models/closing.h` runs it alone.

namespace powbench::sim {

struct PlantOptions {
  double relative_tolerance = 1e-8;  ///< of the integrator, per state scale
  double coil_kelvin = 293.15;       ///< K
  CoilSwitch coil_switch{};
  Suppression suppression{};
};

/// Everything a sensor may want, at one instant. Two breaks of the measured bridge: A and B.
struct PlantSample {
  double time = 0;               ///< s
  double mains_voltage = 0;      ///< V, ahead of the switch
  double coil_voltage = 0;       ///< V, at the coil terminals
  double coil_current = 0;       ///< A
  double flux_linkage = 0;       ///< Wb
  double pull = 0;               ///< N, on the moving core
  double travel = 0;             ///< m, moving core in the laboratory frame (what the laser sees), 0 = open
  double core_velocity = 0;      ///< m/s
  double base = 0;               ///< m, displacement of static core and fixed contacts
  double base_acceleration = 0;  ///< m/s2
  double core_force = 0;         ///< N, core stop contact force (what makes the frame ring)
  double force_a = 0;            ///< N, contact force at break A of the measured pole
  double force_b = 0;            ///< N, at break B
};

/// Exact instants found by the integrator's event location: the simulator's own truth, used to score the
/// extractor.
struct PlantEvent {
  enum class Kind : std::uint8_t {
    touch_a,
    release_a,
    touch_b,
    release_b,
    core_touch,
    core_release,
    stall,
    coil_open
  };
  Kind kind{};
  double time = 0;      ///< s
  double velocity = 0;  ///< m/s, normal approach velocity
};

class Plant {
 public:
  Plant(const Specimen&, const Mains&, const PlantOptions& = {});
  ~Plant();
  Plant(Plant&&) noexcept;
  Plant& operator=(Plant&&) noexcept;

  /// A second plant in the same state: both go on with the same bits.
  Plant copy() const;

  double now() const;  ///< s

  /// Commands the coil switch on or off, from now() on. The default one closes at once and opens at the next zero of
  /// the current.
  void gate(bool on);

  /// Integrates to `t_end` >= now() and fills `out[k]` with the state at `times[k]`, now() < times[k] <=
  /// t_end, ascending. At rest with the coil off nothing is integrated.
  void advance(double t_end, std::span<const double> times, std::span<PlantSample> out);

  /// Events located so far, in order.
  std::span<const PlantEvent> events() const;

  /// Right-hand-side evaluations so far: the cost.
  std::int64_t evaluations() const;

  /// By the mains so far, J.
  double supplied_energy() const;
  /// Energy ledger: |supplied - stored - dissipated| / supplied so far. A check on the integration.
  double energy_residual() const;

 private:
  friend class PlantLanes;  // sim/models/lanes
  struct Impl;
  explicit Plant(std::unique_ptr<Impl>);
  std::unique_ptr<Impl> impl_;
};

}  // namespace powbench::sim
