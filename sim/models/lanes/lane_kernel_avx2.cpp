#define POWBENCH_LANES_AT_ONCE 4
#include "sim/models/lanes/lane_kernel_body.h"

namespace powbench::sim {

void avx2_lane_kernel(const LaneLayout& layout, LaneBlock& block) {
  lane_step(layout, block);
}

}  // namespace powbench::sim
