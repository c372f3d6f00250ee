#include "sim/solid/plastic_kernel_body.h"

namespace powbench::sim {

POWBENCH_CELL_KERNEL(avx2_cell_kernel, "avx2")

}  // namespace powbench::sim
