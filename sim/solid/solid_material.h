#pragma once

#include <limits>
#include <string>

/// What a part is made of.

namespace powbench::sim {

/// How strain becomes stress.
enum class SolidLaw {
  linear,       ///< P = lambda tr(e) I + 2 mu e, e = sym(F) - I: small displacements
  neo_hookean,  ///< P = mu (F - cof F / J) + lambda (J - 1) cof F: elastic at any rotation, W below
  plastic       ///< rate form (Jaumann), von Mises, radial return, linear isotropic hardening
};

/// W of the neo-Hookean law: mu/2 (F:F - 3 - 2 ln J) + lambda/2 (J - 1)^2.
struct SolidMaterial {
  std::string name = "steel";
  double density = 7850;                                   ///< kg/m3
  double young = 2.1e11;                                   ///< Pa
  double poisson = 0.3;                                    ///< -1 < nu < 0.5
  double yield = std::numeric_limits<double>::infinity();  ///< Pa; finite: plastic
  double hardening = 0;                                    ///< Pa, d(yield stress)/d(plastic strain), >= 0
  bool small_displacement = false;  ///< the linear law; not together with a yield stress
  /// Hourglass stiffness in units of the one that bends a brick exactly; (0, 2]. Plastic parts use a tenth of it.
  double hourglass = 1.0;
  double damping = 0;  ///< 1/s, mass-proportional: force -damping m v, >= 0

  SolidLaw law() const {
    return small_displacement                                ? SolidLaw::linear
           : yield < std::numeric_limits<double>::infinity() ? SolidLaw::plastic
                                                             : SolidLaw::neo_hookean;
  }
  double lambda() const { return young * poisson / ((1 + poisson) * (1 - 2 * poisson)); }
  double mu() const { return young / (2 * (1 + poisson)); }
  double wave_modulus() const { return lambda() + 2 * mu(); }  ///< Pa, of plane pressure waves
};

/// Throws std::invalid_argument naming part, key, value and range.
void check_material(const SolidMaterial&);

/// One of the materials contactors are made of: steel, electrical_steel, copper, silver, polyamide (glass-filled).
/// Throws std::invalid_argument with the list for any other name.
SolidMaterial known_material(const std::string& name);

}  // namespace powbench::sim
