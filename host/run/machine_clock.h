#pragma once

#include "core/clock.h"

namespace powbench::host {

/// The clock of this machine, one for the whole program.
Clock& machine_clock();

}  // namespace powbench::host
