#include "sim/solid/cell_kernel.h"
#include "sim/solid/contact_kernel.h"

namespace powbench::sim {

const CellKernel& best_cell_kernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return avx512_cell_kernel();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return avx2_cell_kernel();
#endif
  return portable_cell_kernel();
}

const ContactKernel& best_contact_kernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return avx512_contact_kernel();
  if (__builtin_cpu_supports("avx2")) return avx2_contact_kernel();
#endif
  return portable_contact_kernel();
}

}  // namespace powbench::sim
