#include "bench/mechanics/impacts_peer.h"

namespace powbench::bench {

bool simbody_is_here() {
  return false;
}
std::vector<PeerRow> simbody_bounces(const Bounces&, double) {
  return {};
}
std::vector<PeerRow> simbody_dry_stop(const DryStop&) {
  return {};
}

}  // namespace powbench::bench
