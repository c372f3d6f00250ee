#include "sim/magnetics/plane/four_kernel_body.h"

namespace powbench::sim {

const FourKernel& portable_four_kernel() {
  static const FourKernel kernel{"portable", add_steel, multiply, factor_panel,
                                 square,     add,       forward,  backward};
  return kernel;
}

}  // namespace powbench::sim
