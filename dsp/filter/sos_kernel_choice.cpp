#include "dsp/filter/sos_kernel.h"

namespace powbench::dsp {

const SosKernel& best_sos_kernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) return avx512_sos_kernel();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2_sos_kernel();
#endif
  return portable_sos_kernel();
}

}  // namespace powbench::dsp
