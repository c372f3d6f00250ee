#include "sim/solid/plastic_kernel_body.h"

namespace powbench::sim {

POWBENCH_CELL_KERNEL(portable_cell_kernel, "portable")

}  // namespace powbench::sim
