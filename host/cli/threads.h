#pragma once

#include <algorithm>
#include <thread>

namespace powbench::host {

/// Of `-j N`; 0: one for each core.
inline int worker_count(int asked) {
  return asked > 0 ? asked : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

}  // namespace powbench::host
