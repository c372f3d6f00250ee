#pragma once

#include <array>

#include "firmware/controller.h"
#include "firmware/iiod/model.h"

/// The bench as IIO devices: `contactor-daq` (the record), `contactor-ctl` (state, set-points, actions),
/// trigger `fire`.

namespace powbench::firmware {

class BenchDevices {
 public:
  explicit BenchDevices(Controller& controller);
  BenchDevices(const BenchDevices&) = delete;
  BenchDevices& operator=(const BenchDevices&) = delete;

  const iiod::Device& daq() const { return daq_; }
  const iiod::Device& control() const { return control_; }
  const iiod::Device& trigger() const { return trigger_; }

 private:
  iiod::Device daq_, control_, trigger_;
};

}  // namespace powbench::firmware
