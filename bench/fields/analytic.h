#pragma once

#include <string>
#include <vector>

/// Fields whose solution is known in closed form, each solved by the finite elements of sim/magnetics/plane.

namespace powbench::bench {

struct AnalyticResult {
  std::string name, quantity;
  double exact = 0, found = 0;
  int unknowns = 0;
  double limit = 0.005;  ///< relative error allowed

  double error() const { return found / exact - 1; }
};

/// The loop of a solenoid of zero thickness; field of a cylinder and of a sphere; a slot beside an air gap.
std::vector<AnalyticResult> static_cases();

/// Skin effect in a wire, a lamination, a cylinder and a sphere; a ring in an alternating field.
std::vector<AnalyticResult> alternating_cases();

/// Steel in a close coil and a magnet whose coil fills its gap from pole to pole; flux doubling at switch-on; a
/// shaded pole of gaps alone.
std::vector<AnalyticResult> circuit_cases();

}  // namespace powbench::bench
