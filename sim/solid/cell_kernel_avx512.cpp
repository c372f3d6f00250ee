#include "sim/solid/plastic_kernel_body.h"

namespace powbench::sim {

POWBENCH_CELL_KERNEL(avx512_cell_kernel, "avx512")

}  // namespace powbench::sim
