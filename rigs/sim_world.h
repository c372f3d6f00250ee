#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rigs/board.h"
#include "rigs/plant_stepper.h"
#include "rigs/sensors.h"
#include "rigs/sim_rig_config.h"
#include "sim/models/plant.h"

/// The simulated rig's world: plant, virtual sensors and a board with the firmware in lock-step, in virtual time.
/// Nothing here waits for the wall clock, and a shot depends only on its set-points and seed: arming puts
/// everything into a state that the seed fixes, so that equal shots give equal records bit for bit.

namespace powbench::rigs {

/// Why the firmware refuses the configuration that this makes; empty: it does not.
std::string_view rig_config_error(const SimRigConfig&);

class SimWorld {
 public:
  SimWorld(const SimRigConfig&, const sim::Specimen&, const BoardOptions& = {});
  ~SimWorld();
  SimWorld(const SimWorld&) = delete;
  SimWorld& operator=(const SimWorld&) = delete;

  Board& board() { return *board_; }
  const Board& board() const { return *board_; }

  /// To be called after every request: begins the shot that an `arm` asked for (device at rest, mains
  /// running, phase tracker warmed up).
  void notice_commands();

  /// Something is going on that needs virtual time to pass.
  bool busy() const;

  /// Lets virtual time pass: `seconds`, or less if nothing is going on any more.
  void run(double seconds);

  /// Time from switch-on to the plant's own first touch, settled touch and core seat, in the last shot.
  firmware::PlantTruth truth() const;

  /// Every gate edge of the last shot in plant time, s: when the coil was switched, not when it was asked for.
  std::span<const SwitchEdge> switched() const { return switched_; }
  /// Every gate edge of the last shot as the board scheduled it, in plant time, s.
  double plant_time(firmware::Tick) const;
  std::span<const firmware::GateEdge> scheduled() const { return scheduled_; }

 private:
  void begin_shot(firmware::SetPoints);
  void connect_reference(const firmware::SetPoints&);
  void step_blocks(std::int64_t count);
  void move_relay();
  bool at_rest() const;
  firmware::Block convert_block(std::span<std::int16_t> scans);
  std::vector<SwitchEdge> due_edges(double until);

  SimRigConfig config_;
  sim::Specimen specimen_;
  std::string calibration_id_, boot_id_, secret_;  ///< the board keeps views of them
  std::unique_ptr<Board> board_;

  std::unique_ptr<sim::Plant> plant_;
  std::unique_ptr<SensorChain> sensors_;
  std::uint32_t shots_seen_ = 0;
  std::int64_t reference_channel_ = -1, reference_micro_ = 0;
  std::int64_t sample_ = 0;                    ///< next sample index on the sampling clock
  std::int64_t origin_ = 0;                    ///< sample index at which the plant's time was 0
  std::vector<firmware::GateEdge> edges_;      ///< not yet reached
  std::vector<firmware::GateEdge> scheduled_;  ///< all of this shot
  std::vector<SwitchEdge> switched_;           ///< all that took effect in this shot
  double switched_on_ = -1.0;                  ///< plant time of the last on edge, < 0: not yet in this shot
  bool relay_in_ = false;                      ///< the safety relay is closed
  std::int64_t relay_since_ = 0;               ///< sample at which it last agreed with its command
  bool samples_lost_ = false;                  ///< the fault on request has been played
  std::vector<double> times_;
  std::vector<sim::PlantSample> states_;
  std::vector<std::int16_t> scans_;
};

}  // namespace powbench::rigs
