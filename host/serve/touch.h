#pragma once

#include <optional>
#include <vector>

#include "host/gather/scene.h"

namespace powbench::host {

/// Closing at touch: the closing angle at which the contacts touch at a wanted angle of the mains. The time from
/// switch-on to the first touch depends on the closing angle itself, so with t(a) from the simulator
///
///     a + 2 pi f t(a) = wanted   (mod 2 pi)
///
/// is solved for a: t at 24 angles, then the secant within the interval that holds the solution. Of several solutions
/// the one where an error of the mains' phase moves the touch least.
class TouchAim {
 public:
  struct Aim {
    double wanted = 0;         ///< rad, [0, 2 pi): where the contacts are to touch
    double closing_angle = 0;  ///< rad, [0, 2 pi)
    double touch_time = 0;     ///< s after switch-on, predicted
    double gain = 0;           ///< d(angle of touch) / d(closing angle)
  };
  /// Simulates 24 closings under the plan's conditions.
  TouchAim(const Scene&, const rigs::SimRigConfig&);
  /// Nothing: no closing angle touches there, or the simulated contactor does not close.
  std::optional<Aim> at(double wanted) const;
  /// Made for this plan and specimen.
  bool fits(const Scene&) const;

 private:
  double touch_time(double angle) const;

  sim::Specimen specimen_;
  Conditions conditions_;
  rigs::SimRigConfig rig_;
  RunOptions options_;
  std::string plan_hash_, specimen_hash_;
  std::vector<double> times_;  ///< s, at even steps of the closing angle; NaN: no touch
};

}  // namespace powbench::host
