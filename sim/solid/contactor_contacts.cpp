#include "sim/solid/contactor_contacts.h"

#include <algorithm>
#include <cmath>

#include "sim/mechanics/contact_damping.h"

namespace powbench::sim {
namespace {

struct Layer {
  double stiffness = 0, damping = 0;  ///< N/m, N s/m
};

/// m2: of the faces of a and b that meet when b has gone up by `gap`, mean of both ways; measured with a layer of
/// 1 Pa/m that is pressed by a micrometre.
double meeting_area(const CellBatches& cells, int a, int b, double gap) {
  constexpr double pressed = 1e-6;
  const std::size_t nodes = cells.mesh().nodes.size();
  std::vector<double> inverse_mass(4 * nodes, 0.0), u(4 * nodes, 0.0), v(4 * nodes, 0.0);
  for (int n = cells.nodes_begin(b); n < cells.nodes_end(b); ++n)
    u[4 * static_cast<std::size_t>(n) + 2] = gap + pressed;
  ContactPair pair;
  pair.a = a;
  pair.b = b;
  pair.layer = 1;
  SolidContact contact(cells, inverse_mass, {{pair}, false});
  NodeForces forces(nodes), damped(nodes);
  contact.apply({&cells.mesh().nodes, u.data(), v.data()}, 0, forces, damped);
  return contact.report(0).force_sum / pressed;
}

void add_pair(ContactOptions& options, const CellBatches& cells, int a, int b, double gap, const Layer& sum) {
  ContactPair pair;
  pair.a = a;
  pair.b = b;
  const double area = meeting_area(cells, a, b, gap);
  pair.layer = sum.stiffness / area;
  pair.layer_damping = sum.damping / area;
  options.pairs.push_back(pair);
}

/// Under the lowest face of a part, `depth` into it once the part has gone down by `down`.
SolidPlane rest_under(const CellBatches& cells, int part, const Layer& sum, double down, double depth) {
  const SolidSurface skin = surface_of(cells.mesh(), part, cells.material(part));
  const auto place = [&](int n) { return cells.mesh().nodes[static_cast<std::size_t>(n)]; };
  double low = 1e300, area = 0;
  for (const int n : skin.nodes) low = std::min(low, place(n).z);
  SolidPlane plane;
  plane.point = {0, 0, low - down + depth};
  std::vector<double> shares;
  for (std::size_t k = 0; k < skin.nodes.size(); ++k) {
    if (place(skin.nodes[k]).z > low + 1e-9) continue;
    plane.nodes.push_back(skin.nodes[k]);
    shares.push_back(skin.area_along(k, plane.normal, place));
    area += shares.back();
  }
  for (const double s : shares) {
    plane.stiffness.push_back(sum.stiffness * s / area);
    plane.damping.push_back(sum.damping * s / area);
  }
  return plane;
}

}  // namespace

ContactorContacts contactor_contacts(const ContactorMesh& c, const CellBatches& cells, const Specimen& s) {
  const Bridges& b = s.bridges;
  const Layer pad{b.contact_stiffness, pad_damping(s)}, seat{b.seat_stiffness, seat_damping(s)},
      stop{s.core.stop_stiffness, stop_damping(s)};
  ContactorContacts all;
  all.options.edges = false;  // all faces that meet are level
  for (const int bridge : c.bridges) add_pair(all.options, cells, c.base, bridge, b.gap, pad);
  all.stop = static_cast<int>(all.options.pairs.size());
  add_pair(all.options, cells, c.base, c.mover, s.core.travel, stop);
  for (const int bridge : c.bridges) add_pair(all.options, cells, c.mover, bridge, 0, seat);
  all.seat_depth = b.preload / b.seat_stiffness;
  all.rest = rest_under(cells, c.mover, stop, all.seat_depth, s.core.return_preload / s.core.stop_stiffness);
  return all;
}

}  // namespace powbench::sim
