#include "sim/solid/contact_kernel_body.h"

namespace powbench::sim {

POWBENCH_CONTACT_KERNEL(portable_contact_kernel, "portable", D4)

}  // namespace powbench::sim
