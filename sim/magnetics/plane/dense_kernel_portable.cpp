namespace powbench::sim {
namespace {
constexpr int lanes = 2;
constexpr int columns = 4;
}  // namespace
}  // namespace powbench::sim

#include "sim/magnetics/plane/dense_kernel_body.h"

namespace powbench::sim {

const DenseKernel& portable_dense_kernel() {
  static const DenseKernel kernel{"portable", subtract_square, factor_panel, forward, backward};
  return kernel;
}

}  // namespace powbench::sim
