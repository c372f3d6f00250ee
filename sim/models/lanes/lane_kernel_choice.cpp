#include "sim/models/lanes/lane_block.h"

namespace powbench::sim {

LaneKernel best_lane_kernel() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return avx512_lane_kernel;
  if (__builtin_cpu_supports("avx2")) return avx2_lane_kernel;
#endif
  return portable_lane_kernel;
}

}  // namespace powbench::sim
