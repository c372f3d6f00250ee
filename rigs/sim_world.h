#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/bench_devices.h"
#include "firmware/controller.h"
#include "rigs/plant_stepper.h"
#include "rigs/sensors.h"
#include "rigs/sim_rig_config.h"
#include "sim/plant.h"

/// The simulated rig's world: plant, virtual sensors and the native firmware in lock-step, in virtual time.
/// Nothing here waits for the wall clock, and a shot depends only on its set-points and seed: arming puts
/// everything into a state that the seed fixes, so that equal shots give equal records bit for bit.

namespace powbench::rigs {

/// What a programmable source and chamber would be told. Written through the `contactor-plant` device.
struct SetPoints {
  std::int64_t supply_millivolts = 230'000;  ///< rms
  std::int64_t mains_millihertz = 50'000;
  std::int64_t ambient_millidegc = 20'000;
  std::int64_t seed = 1;  ///< of the next shot; counts up when a shot begins
};

class SimWorld {
 public:
  SimWorld(const SimRigConfig&, const sim::Specimen&);
  ~SimWorld();
  SimWorld(const SimWorld&) = delete;
  SimWorld& operator=(const SimWorld&) = delete;

  const firmware::iiod::Context& context() const { return context_; }
  firmware::Controller& controller() { return *controller_; }
  const sim::Specimen& specimen() const { return specimen_; }
  SetPoints& set_points() { return set_points_; }

  /// To be called after every request: begins the shot that an `arm` asked for (device at rest, mains
  /// running, phase tracker warmed up).
  void notice_commands();

  /// Something is going on that needs virtual time to pass.
  bool busy() const;

  /// A client is connected. In virtual time an open connection is the heartbeat: how often it speaks says
  /// nothing.
  void host_connected(bool yes) { host_connected_ = yes; }

  /// Lets virtual time pass: `seconds`, or less if nothing is going on any more.
  void run(double seconds);

  /// Time from switch-on to the plant's own first touch, settled touch and core seat, in the last shot, s;
  /// NaN: none.
  struct Truth {
    double touch, settled, seat;
  };
  Truth truth() const;

 private:
  void begin_shot();
  void step_block();
  std::vector<SwitchEdge> due_edges(double until);
  double plant_time(firmware::Tick) const;

  SimRigConfig config_;
  sim::Specimen specimen_;
  SetPoints set_points_;
  std::vector<std::int16_t> storage_;
  std::string calibration_id_;
  std::unique_ptr<firmware::Controller> controller_;
  std::unique_ptr<firmware::BenchDevices> devices_;
  struct PlantDevice;
  std::unique_ptr<PlantDevice> plant_device_;
  std::array<const firmware::iiod::Device*, 4> device_list_{};
  std::vector<firmware::iiod::ContextAttribute> context_attributes_;
  std::string boot_id_;
  firmware::iiod::Context context_;

  std::unique_ptr<sim::Plant> plant_;
  std::unique_ptr<SensorChain> sensors_;
  std::uint32_t shots_seen_ = 0;
  std::int64_t sample_ = 0;  ///< next sample index on the sampling clock
  std::int64_t origin_ = 0;  ///< sample index at which the plant's time was 0
  std::vector<firmware::GateEdge> edges_;
  double switched_on_ = -1.0;  ///< plant time of the last on edge, < 0: not yet in this shot
  bool host_connected_ = true;
  bool samples_lost_ = false;  ///< the fault on request has been played
  std::vector<double> times_;
  std::vector<sim::PlantSample> states_;
  std::vector<std::int16_t> scans_;
};

}  // namespace powbench::rigs
