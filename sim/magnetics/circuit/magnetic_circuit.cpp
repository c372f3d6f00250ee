#include "sim/magnetics/circuit/magnetic_circuit.h"

#include <cmath>

#include "sim/magnetics/circuit/lumped_magnet.h"

namespace powbench::sim {

MagneticCircuit::MagneticCircuit(const Magnet& magnet, double travel)
    : n_{.area = magnet.pole_area,
         .iron_length = magnet.iron_length,
         .residual = magnet.residual_gap,
         .fringe = magnet.fringing / std::sqrt(magnet.pole_area),
         .share = magnet.shaded_share,
         .inverse_bare = 1 / (1 - magnet.shaded_share),
         .inverse_shaded = magnet.shaded_share > 0 ? 1 / magnet.shaded_share : 0.0,
         .ring_resistance = magnet.ring_resistance,
         .linear = magnet.bh_linear,
         .saturation = magnet.bh_power,
         .exponent = magnet.bh_exponent,
         .iron_per_area = magnet.iron_length / magnet.pole_area,
         .volume = magnet.pole_area * magnet.iron_length,
         .mu0_area = mu0 * magnet.pole_area,
         .one_bare = 1 + 1 / (1 - magnet.shaded_share)},
      even_power_(-1),
      has_ring_(false) {
  if (!magnet.steel.empty()) steel_ = std::make_shared<const Steel>(steel_of(magnet));
  const double half = (n_.exponent - 1) / 2;
  if (half == std::floor(half) && half >= 1 && half <= 50) even_power_ = static_cast<int>(2 * half);
  if (n_.share > 0) {
    constexpr double fastest = 2e7;  // 1/s
    const double g = gap(travel);
    const double r = g / (n_.mu0_area * (1 + n_.fringe * g));
    has_ring_ = n_.ring_resistance * r * (n_.inverse_bare + n_.inverse_shaded) < fastest;
  }
}

}  // namespace powbench::sim
