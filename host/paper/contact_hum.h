#pragma once

#include <string>
#include <vector>

#include "sim/specimen/specimen.h"

/// Where a pulsation of the contact pressure after settling can come from.

namespace powbench::host {

/// The force after settling where the pulsation of the pull meets a compliance.
struct HumLine {
  std::string what;
  double low, high;  ///< N, pull over the last period
  double swing_um;   ///< of the overtravel there
  double second,
      expected;       ///< N at twice the mains frequency, found and k_c / 2 times that of the overtravel
  std::size_t lifts;  ///< releases of the core in the last 100 ms
};

/// The compliances: the pole faces as they are and more compliant ones; then a ring too weak to hold the core through
/// the pull's minimum. Each closing at 0 deg under the paper's conditions is held for 0.4 s.
std::vector<HumLine> hum_lines(const sim::Specimen&);

}  // namespace powbench::host
