#include "sim/magnetics/plane/four_kernel_body.h"

namespace powbench::sim {

const FourKernel& avx2_four_kernel() {
  static const FourKernel kernel{"avx2", add_steel, multiply, factor_panel, square, add, forward, backward};
  return kernel;
}

}  // namespace powbench::sim
