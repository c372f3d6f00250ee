#include "sim/solid/contact_kernel_body.h"

namespace powbench::sim {

POWBENCH_CONTACT_KERNEL(avx2_contact_kernel, "avx2", D4)

}  // namespace powbench::sim
