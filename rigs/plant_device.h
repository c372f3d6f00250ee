#pragma once

#include "firmware/iiod/model.h"
#include "rigs/sim_world.h"

namespace powbench::rigs {

/// The `contactor-plant` device: set-points of the source and the chamber, and the plant's own truth. A rig
/// without a programmable source simply does not have it; the host asks, it does not assume.
struct SimWorld::PlantDevice {
  explicit PlantDevice(SimWorld& world);
  const firmware::iiod::Device& device() const { return device_; }

 private:
  firmware::iiod::Device device_;
};

}  // namespace powbench::rigs
