#include "sim/mechanics/contact_law.h"

#include <cmath>

namespace powbench::sim {

double hunt_crossley_restitution(double lambda_v) {
  if (lambda_v <= 0) return 1;
  double low = 0;
  double high = std::min(1.0, 1 / lambda_v);
  for (int i = 0; i < 200; ++i) {
    const double e = 0.5 * (low + high);
    if (e <= low || e >= high) break;
    const double f = std::log1p(lambda_v) - std::log1p(-lambda_v * e) - lambda_v * (1 + e);
    (f < 0 ? low : high) = e;
  }
  return 0.5 * (low + high);
}

double hunt_crossley_approach(double restitution) {
  double low = 0, high = 1;
  while (hunt_crossley_restitution(high) > restitution) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-16 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (hunt_crossley_restitution(middle) > restitution ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace powbench::sim
