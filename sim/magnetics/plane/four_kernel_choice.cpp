#include "sim/magnetics/plane/four_kernel.h"

namespace powbench::sim {

const FourKernel& best_four_kernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2_four_kernel();
#endif
  return portable_four_kernel();
}

}  // namespace powbench::sim
