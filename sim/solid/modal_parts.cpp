#include "sim/solid/modal_parts.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "sim/solid/contactor_mesh.h"
#include "sim/solid/modal_body.h"

namespace powbench::sim {
namespace {

constexpr double slack = 1e-9;  // m

/// One part of a mesh as a mesh of its own.
SolidMesh part_of(const SolidMesh& mesh, int part) {
  SolidMesh one;
  one.add_part(mesh.parts[static_cast<std::size_t>(part)]);
  std::vector<int> number(mesh.nodes.size(), -1);
  for (SolidCell cell : mesh.cells) {
    if (cell.part != part) continue;
    for (int c = 0; c < cell.corners(); ++c) {
      int& node = cell.nodes[static_cast<std::size_t>(c)];
      int& mine = number[static_cast<std::size_t>(node)];
      if (mine < 0) {
        mine = static_cast<int>(one.nodes.size());
        one.nodes.push_back(mesh.nodes[static_cast<std::size_t>(node)]);
      }
      node = mine;
    }
    cell.part = 0;
    one.cells.push_back(cell);
  }
  return one;
}

/// Equal shares of all nodes that a test picks.
Attachment at_nodes(const SolidMesh& mesh, const std::function<bool(const Vec3&)>& picked) {
  Attachment a;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (picked(mesh.nodes[n])) a.at.nodes.push_back(static_cast<int>(n));
  if (a.at.nodes.empty()) throw std::invalid_argument("cell: too large, a contact has no node of its own");
  a.at.shares.assign(a.at.nodes.size(), 1.0 / static_cast<double>(a.at.nodes.size()));
  return a;
}

ElasticPart elastic_part(const SolidMesh& mesh, SolidMaterial material, int modes,
                         const std::vector<Attachment>& places, const ModalPartsOptions& o) {
  material.young *= o.stiffness;
  const ModalBody body = reduce(mesh, material, modes, o.attached ? places : std::vector<Attachment>{});
  ElasticPart part;
  part.shape.resize(places.size());
  for (int r = 6; r < body.modes(); ++r) {
    if (body.omega[static_cast<std::size_t>(r)] > o.highest * std::sqrt(o.stiffness)) continue;
    std::vector<double> at(places.size(), 0.0);
    double largest = 0;
    for (std::size_t p = 0; p < places.size(); ++p) {
      const auto& where = places[p].at;
      for (std::size_t n = 0; n < where.nodes.size(); ++n)
        at[p] += where.shares[n] * body.shape(r, where.nodes[n]).z;
      largest = std::max(largest, std::fabs(at[p]));
    }
    if (largest < 1e-6) continue;  // moves sideways only
    part.omega.push_back(body.omega[static_cast<std::size_t>(r)]);
    for (std::size_t p = 0; p < places.size(); ++p) part.shape[p].push_back(at[p]);
  }
  return part;
}

void check(const ModalPartsOptions& o) {
  const auto fail = [](const char* key, double value, const char* allowed) {
    throw std::invalid_argument(std::string(key) + " = " + std::to_string(value) + ", allowed " + allowed);
  };
  if (!(o.base_modes >= 0 && o.base_modes <= 60)) fail("base_modes", o.base_modes, "0 .. 60");
  if (!(o.bridge_modes >= 0 && o.bridge_modes <= 60)) fail("bridge_modes", o.bridge_modes, "0 .. 60");
  if (!(o.stiffness > 0)) fail("stiffness", o.stiffness, "above 0");
  if (!(o.highest > 0)) fail("highest", o.highest, "above 0");
}

}  // namespace

ModalParts modal_parts(const Specimen& specimen, const ModalPartsOptions& o) {
  check(o);
  const ContactorMesh contactor = contactor_mesh(specimen, o.cell);
  const Bridges& b = specimen.bridges;
  ModalParts parts;

  const SolidMesh base = part_of(contactor.mesh, contactor.base);
  double low = 1e300, plate = 1e300;  // m: fixed contacts, underside of the plate between them
  for (const auto& p : base.nodes) {
    low = std::min(low, p.z);
    if (std::fabs(p.x) < b.seat_half_length + slack) plate = std::min(plate, p.z);
  }
  std::vector<Attachment> places;
  for (const int bridge : contactor.bridges) {
    double from = 1e300, to = -1e300;  // m, across: the bridge's own posts
    for (const auto& c : contactor.mesh.cells) {
      if (c.part != bridge) continue;
      for (const int n : c.nodes) {
        from = std::min(from, contactor.mesh.nodes[static_cast<std::size_t>(n)].y);
        to = std::max(to, contactor.mesh.nodes[static_cast<std::size_t>(n)].y);
      }
    }
    for (const double side : {-1.0, 1.0})
      places.push_back(at_nodes(base, [&](const Vec3& p) {
        return p.z < low + slack && side * p.x > 0 && p.y > from - slack && p.y < to + slack;
      }));
  }
  places.push_back(at_nodes(base, [&](const Vec3& p) {
    return std::fabs(p.z - plate) < slack && std::fabs(p.x) < b.seat_half_length + slack;
  }));
  parts.base_nodes = static_cast<int>(base.nodes.size());
  parts.base = elastic_part(base, contactor.materials[static_cast<std::size_t>(contactor.base)], o.base_modes,
                            places, o);

  const SolidMesh bridge = part_of(contactor.mesh, contactor.bridges.front());
  const double inner = b.half_length - 2e-3 - slack, seat = b.seat_half_length;
  std::vector<Attachment> on_bridge;
  for (const double side : {-1.0, 1.0})
    on_bridge.push_back(at_nodes(bridge, [&](const Vec3& p) { return p.z > -slack && side * p.x > inner; }));
  for (const double side : {-1.0, 1.0})
    on_bridge.push_back(at_nodes(
        bridge, [&](const Vec3& p) { return p.z > -slack && std::fabs(side * p.x - seat) < slack; }));
  on_bridge.push_back(at_nodes(bridge, [&](const Vec3& p) {
    return p.z < -contactor.bridge_thickness + slack && std::fabs(p.x) < seat + slack;
  }));
  parts.bridge_nodes = static_cast<int>(bridge.nodes.size());
  parts.bridge =
      elastic_part(bridge, contactor.materials[static_cast<std::size_t>(contactor.bridges.front())],
                   o.bridge_modes, on_bridge, o);
  return parts;
}

}  // namespace powbench::sim
