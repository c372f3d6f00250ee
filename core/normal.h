#pragma once

#include <boost/math/special_functions/erf.hpp>
#include <cmath>

namespace powbench {

/// Inverse of the standard normal distribution for 0 < p < 1, to the last digits. x = -sqrt 2 erfc^-1(2 p).
inline double normal_quantile(double p) {
  return -std::sqrt(2.0) * boost::math::erfc_inv(2 * p);
}

}  // namespace powbench
