#pragma once

#include <string>
#include <vector>

#include "sim/models/solenoid/solenoid_model.h"

/// A closing of a solenoid over time, as a table or a picture.

namespace powbench::host {

/// One header line with units, one line a sample, SI.
std::string solenoid_csv(const std::vector<sim::SolenoidSample>&);

/// What happens at a time, s.
struct TimeMark {
  double time = 0;
  std::string name;
};

/// Coil voltage, current, position and pull over time, one panel each, with lines at the marks.
std::string solenoid_svg(const std::vector<sim::SolenoidSample>&, const std::vector<TimeMark>&,
                         const std::string& title);

}  // namespace powbench::host
