#pragma once

#include <array>

#include "firmware/controller.h"
#include "firmware/iiod/model.h"
#include "firmware/source_device.h"

/// The bench as IIO devices: `contactor-daq` (the record), `contactor-ctl` (state, set-points, actions),
/// trigger `fire`.

namespace powbench::firmware {

class BenchDevices {
 public:
  /// `source`: set-points of a programmable source, if there is one.
  explicit BenchDevices(Controller& controller, const SetPoints* source = nullptr);
  BenchDevices(const BenchDevices&) = delete;
  BenchDevices& operator=(const BenchDevices&) = delete;

  const iiod::Device& daq() const { return daq_; }
  const iiod::Device& control() const { return control_; }
  const iiod::Device& trigger() const { return trigger_; }

  /// The context attributes that say which rig this is; they must outlive the devices.
  void identify(std::span<const iiod::ContextAttribute> identity) { identity_ = identity; }
  std::span<const iiod::ContextAttribute> identity() const { return identity_; }
  /// The source's set-points are those of the shot that has just been armed.
  void latch_source() {
    if (set_points_) latched_ = *set_points_;
  }
  /// The source's set-points of the last shot armed; nullptr: the rig has no source.
  const SetPoints* source() const { return set_points_ ? &latched_ : nullptr; }
  Controller& controller() { return controller_; }
  const Controller& controller() const { return controller_; }

 private:
  Controller& controller_;
  const SetPoints* set_points_;
  SetPoints latched_;
  std::span<const iiod::ContextAttribute> identity_{};
  iiod::Device daq_, control_, trigger_;
};

}  // namespace powbench::firmware
