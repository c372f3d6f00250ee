#include "sim/magnetic_circuit.h"

#include <cmath>

#include "sim/specimen_steel.h"

namespace powbench::sim {

MagneticCircuit::MagneticCircuit(const Magnet& magnet, double travel)
    : area_(magnet.pole_area),
      iron_length_(magnet.iron_length),
      residual_(magnet.residual_gap),
      fringe_(magnet.fringing / std::sqrt(magnet.pole_area)),
      share_(magnet.shaded_share),
      inverse_bare_(1 / (1 - magnet.shaded_share)),
      inverse_shaded_(magnet.shaded_share > 0 ? 1 / magnet.shaded_share : 0.0),
      ring_resistance_(magnet.ring_resistance),
      linear_(magnet.bh_linear),
      saturation_(magnet.bh_power),
      exponent_(magnet.bh_exponent),
      even_power_(-1),
      has_ring_(false) {
  if (!magnet.steel.empty()) steel_ = std::make_shared<const Steel>(steel_of(magnet));
  const double half = (exponent_ - 1) / 2;
  if (half == std::floor(half) && half >= 1 && half <= 50) even_power_ = static_cast<int>(2 * half);
  if (share_ > 0) {
    constexpr double fastest = 2e7;  // 1/s
    const double g = gap(travel);
    const double r = g / (mu0 * area_ * (1 + fringe_ * g));
    has_ring_ = ring_resistance_ * r * (inverse_bare_ + inverse_shaded_) < fastest;
  }
}

}  // namespace powbench::sim
