#include "bench/mechanics/rigid_runs.h"

namespace powbench::bench {

bool have_sundials() {
  return false;
}
std::vector<std::string> sundials_methods() {
  return {};
}
ClosingRun sundials_run(const std::string& method, const sim::RigidParts&, double, int) {
  ClosingRun r;
  r.method = method;
  r.finished = false;
  return r;
}

}  // namespace powbench::bench
