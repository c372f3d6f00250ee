namespace powbench::sim {
namespace {
constexpr int lanes = 8;
constexpr int columns = 8;
}  // namespace
}  // namespace powbench::sim

#include "sim/magnetics/plane/dense_kernel_body.h"

namespace powbench::sim {

const DenseKernel& avx512_dense_kernel() {
  static const DenseKernel kernel{"avx512", subtract_square, factor_panel, forward, backward};
  return kernel;
}

}  // namespace powbench::sim
