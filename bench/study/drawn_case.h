#pragma once

#include <span>
#include <vector>

#include "core/random.h"
#include "core/units.h"
#include "sim/models/rung.h"
#include "sim/study/parameter.h"

namespace bench {

/// A specimen between the bounds of these numbers, angle anywhere, 0.85 .. 1.1 of 230 V, coil at -5 .. 60 degC.
inline powbench::sim::Case drawn_case(powbench::Random& random,
                                      std::span<const powbench::sim::Parameter> parameters) {
  std::vector<double> place(parameters.size());
  for (double& x : place) x = random.uniform();
  powbench::sim::Case c;
  c.conditions.closing_angle = 2 * powbench::pi * random.uniform();
  c.conditions.supply_volts = 230 * (0.85 + 0.25 * random.uniform());
  c.conditions.ambient = powbench::zero_celsius - 5 + 65 * random.uniform();
  c.specimen = powbench::sim::specimen_at({}, parameters, place);
  return c;
}

}  // namespace bench
