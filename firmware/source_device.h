#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/controller.h"
#include "firmware/iiod/model.h"

namespace powbench::firmware {

/// Set-points of a programmable source and a chamber. A rig without them simply does not have the device; the
/// host asks, it does not assume.
struct SetPoints {
  std::int64_t supply_millivolts = 230'000;  ///< rms
  std::int64_t mains_millihertz = 50'000;
  std::int64_t ambient_millidegc = 20'000;
  std::int64_t seed = 1;                ///< of the next shot; counts up when a shot begins
  std::int64_t reference_channel = -1;  ///< input that is connected to a source of known quantity; -1: none
  std::int64_t reference_micro = 0;     ///< that quantity, 1e-6 SI
};

/// Time from switch-on to the simulated plant's own events in the last shot, ns; `none`: it did not happen.
struct PlantTruth {
  static constexpr std::int64_t none = INT64_MIN;
  std::int64_t touch_ns = none, settled_ns = none, seat_ns = none;
};

/// The `contactor-plant` device: set-points, and what the plant itself says. The port reads the set-points
/// and fills in the truth.
class SourceDevice {
 public:
  SourceDevice(std::string_view specimen, Controller& controller);
  SourceDevice(const SourceDevice&) = delete;
  SourceDevice& operator=(const SourceDevice&) = delete;

  const iiod::Device& device() const { return device_; }

  SetPoints set_points;
  PlantTruth truth;
  std::string_view specimen;
  Controller& controller;  ///< whose owner may set them

 private:
  iiod::Device device_;
};

}  // namespace powbench::firmware
