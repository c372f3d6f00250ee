namespace powbench::sim {
namespace {
constexpr int lanes = 4;
constexpr int columns = 4;
}  // namespace
}  // namespace powbench::sim

#include "sim/magnetics/plane/dense_kernel_body.h"

namespace powbench::sim {

const DenseKernel& avx2_dense_kernel() {
  static const DenseKernel kernel{"avx2", subtract_square, factor_panel, forward, backward};
  return kernel;
}

}  // namespace powbench::sim
