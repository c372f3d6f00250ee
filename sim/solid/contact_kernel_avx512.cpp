#include "sim/solid/contact_kernel_body.h"

namespace powbench::sim {

POWBENCH_CONTACT_KERNEL(avx512_contact_kernel, "avx512", D8)

}  // namespace powbench::sim
