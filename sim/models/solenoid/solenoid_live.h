#pragma once

#include <vector>

#include "sim/magnetics/potential.h"
#include "sim/models/solenoid/solenoid_specimen.h"

/// The field of a solenoid as a potential: each state is solved anew by finite elements.

namespace powbench::sim {

/// The start of each solution is the one before, so that equal states give equal values to the tolerance of Newton's
/// method and no further; one thread only. Energies of two gaps differ from the pull by the error of the mesh (see
/// SolenoidField).
class LiveSolenoid final : public MagneticPotential {
 public:
  LiveSolenoid(const SolenoidDesign&, const FieldOptions&);

  bool has_ring() const override { return false; }
  /// Gaps below 0 go on linearly, as those of a table. Throws std::runtime_error where Newton does not converge.
  MagneticResponse at(const MagneticState&) const override;

  int unknowns() const { return field_.unknowns(); }

 private:
  mutable SolenoidField field_;
  mutable std::vector<double> start_;
  mutable double gap_ = -1;  ///< m, the last one
  double largest_gap_;
  bool magnet_;
};

}  // namespace powbench::sim
