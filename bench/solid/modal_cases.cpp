// Reduced bodies against the finite elements they come from.

#include <algorithm>
#include <cmath>

#include "bench/solid/impact_cases.h"
#include "core/cpu_time.h"
#include "sim/solid/modal_body.h"

namespace powbench::bench {
namespace {

using namespace sim;

/// Linear interpolation of a force sampled at the ends of steps dt.
double at(const std::vector<double>& force, double dt, double time) {
  const double place = time / dt;
  const auto k = static_cast<std::size_t>(place);
  if (k + 1 >= force.size()) return 0;
  const double part = place - static_cast<double>(k);
  return (1 - part) * force[k] + part * force[k + 1];
}

}  // namespace

std::vector<BridgeOnPads> bridge_on_pads(const std::vector<int>& counts, bool attached) {
  SolidMesh mesh;
  const double length = 24e-3, wide = 6e-3, high = 1.5e-3, pad = 2e-3, end = 700e-6, speed = 0.6;
  add_box(mesh, mesh.add_part("bridge"), {0, 0, 0}, {length, wide, high}, 24, 6, 3);
  SolidMaterial copper = known_material("copper");
  copper.small_displacement = true;
  std::vector<SolidPlane> pads(2);
  std::vector<Attachment> attachments(2);
  for (std::size_t k = 0; k < 2; ++k) {
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
      const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
      if (p.z < 1e-9 && std::fabs(p.y - wide / 2) < 1.01e-3 &&
          (k == 0 ? p.x < pad + 1e-9 : p.x > length - pad - 1e-9))
        pads[k].nodes.push_back(n);
    }
    const auto count = pads[k].nodes.size();
    pads[k].stiffness.assign(count, 3e6 / static_cast<double>(count));
    attachments[k].at = {pads[k].nodes, std::vector<double>(count, 1.0 / static_cast<double>(count))};
  }
  SolidOptions options;
  options.ledger_every = 0;
  ExplicitSolid full(mesh, {copper}, options);
  for (const auto& p : pads) full.add_plane(p);
  full.set_velocity(0, {0, 0, -speed});
  std::vector<double> force;
  double start = process_cpu_seconds();
  while (full.time() < end) {
    full.step();
    force.push_back(full.plane_force());
  }
  const double full_cpu = process_cpu_seconds() - start, peak = *std::max_element(force.begin(), force.end());
  std::vector<BridgeOnPads> all;
  for (const int count : counts) {
    const ModalBody body = reduce(mesh, copper, count, attached ? attachments : std::vector<Attachment>{});
    ModalMotion motion(body, mesh, pads);
    motion.set_velocity({0, 0, -speed});
    BridgeOnPads r;
    r.modes = body.modes() - 6;
    std::vector<double> reduced;
    start = process_cpu_seconds();
    while (motion.time() < end) {
      motion.step();
      reduced.push_back(motion.plane_force());
    }
    r.cpu_ratio = full_cpu / (process_cpu_seconds() - start);
    double squares = 0, impulse = 0, whole = 0;
    for (std::size_t k = 0; k < force.size(); ++k) {
      const double difference = at(reduced, motion.dt(), static_cast<double>(k) * full.dt()) - force[k];
      r.worst = std::max(r.worst, std::fabs(difference) / peak);
      squares += difference * difference;
      impulse += difference;
      whole += force[k];
    }
    r.rms = std::sqrt(squares / static_cast<double>(force.size())) / peak;
    r.impulse_error = impulse / whole;
    r.peak_error = *std::max_element(reduced.begin(), reduced.end()) / peak - 1;
    all.push_back(r);
  }
  return all;
}

}  // namespace powbench::bench
