#include "sim/magnetics/plane/dense_kernel.h"

namespace powbench::sim {

const DenseKernel& best_dense_kernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) return avx512_dense_kernel();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2_dense_kernel();
#endif
  return portable_dense_kernel();
}

}  // namespace powbench::sim
