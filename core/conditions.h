#pragma once

#include <cstdint>
#include <string>

#include "core/units.h"

namespace powbench {

/// What one closing was asked to be. Filled by the plan; stored with every record; SI.
struct Conditions {
  double supply_volts = 230.0;  ///< V rms at the coil terminals, open circuit
  double mains_hertz = 50.0;    ///< Hz
  double closing_angle = 0.0;   ///< rad, [0, 2 pi): commanded phase of the coil voltage at switch-on
  double angle_tolerance =
      radians(1.0);          ///< rad, 0.01 .. 90 deg: not fired unless 3 u of the phase are within it
  int polarity = +1;         ///< +1, or -1: fire half a period later (closing_angle + pi)
  double hold_time = 0.100;  ///< s: how long the coil stays switched on
  double ambient = 20.0 + zero_celsius;  ///< K: also the coil temperature at the start
  std::string specimen = "reference";    ///< name of the specimen
  std::uint64_t seed = 1;                ///< seed of everything random in this shot
};

}  // namespace powbench
