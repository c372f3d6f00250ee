#define POWBENCH_LANES_AT_ONCE 2
#include "sim/models/lanes/lane_kernel_body.h"

namespace powbench::sim {

void portable_lane_kernel(const LaneLayout& layout, LaneBlock& block) {
  lane_step(layout, block);
}

}  // namespace powbench::sim
