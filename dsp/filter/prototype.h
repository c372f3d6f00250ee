#pragma once

#include <complex>
#include <vector>

#include "dsp/filter/filter_design.h"

/// Analog low-pass prototypes with their edge at 1 rad/s.

namespace powbench::dsp {

struct Prototype {
  std::vector<double> zeros;  ///< rad/s > 0: each stands for the pair +-i w on the imaginary axis
  std::vector<std::complex<double>> poles;  ///< left half plane, conjugates both listed
  double gain = 1.0;                        ///< of prod(s - zeros) / prod(s - poles)
  double dc_gain = 1.0;                     ///< |H(0)|: below 1 for even orders with ripple in the pass band
};

/// Order 1 .. 16, ripple_db > 0, stop_db > ripple_db as far as the family uses them (not checked here).
Prototype prototype(FilterFamily, int order, double ripple_db, double stop_db);

/// 10^(db / 10) - 1 without cancellation.
double excess_power(double db);

}  // namespace powbench::dsp
