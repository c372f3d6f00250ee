#include "sim/solid/import_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace powbench::sim {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The one physical volume that a block of cells belongs to.
const MshGroup& group_of(const MshMesh& from, const MshBlock& block) {
  const MshGroup* found = nullptr;
  for (const auto& g : from.groups) {
    if (g.dimension != 3 || std::find(block.groups.begin(), block.groups.end(), g.tag) == block.groups.end())
      continue;
    if (found)
      throw std::invalid_argument("mesh: volume " + std::to_string(block.entity) +
                                  " belongs to two physical volumes, allowed one");
    found = &g;
  }
  if (!found)
    throw std::invalid_argument("mesh: volume " + std::to_string(block.entity) +
                                " belongs to no physical volume; each part needs one");
  return *found;
}

std::string name_of(const MshGroup& g) {
  return g.name.empty() ? "volume " + std::to_string(g.tag) : g.name;
}

void check_extent(const SolidMesh& mesh, std::size_t first, const std::string& name) {
  double largest = 0;
  for (const double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t n = first; n < mesh.nodes.size(); ++n) {
      low = std::min(low, mesh.nodes[n].*axis);
      high = std::max(high, mesh.nodes[n].*axis);
    }
    largest = std::max(largest, high - low);
  }
  if (!(largest >= 0.1e-3 && largest <= 1))
    throw std::invalid_argument("mesh: part '" + name + "' is " + std::to_string(largest * 1e3) +
                                " mm long, allowed 0.1 .. 1000; is the unit of the file right?");
}

}  // namespace

SolidMesh import_solid_mesh(const MshMesh& from, double metres) {
  if (!(metres > 0))
    throw std::invalid_argument("mesh: " + std::to_string(metres) + " m a unit, allowed above 0");
  std::map<int, std::vector<const MshBlock*>> blocks;  // by tag of the group
  for (const auto& b : from.blocks) {
    if (msh_dimension(b.shape) != 3) continue;
    if (b.order != 1)
      throw std::invalid_argument("mesh: volume " + std::to_string(b.entity) +
                                  " has cells of second order, allowed the first");
    blocks[group_of(from, b).tag].push_back(&b);
  }
  if (blocks.empty()) throw std::invalid_argument("mesh: no tetrahedra or hexahedra");
  SolidMesh mesh;
  constexpr int unseen = -1;
  std::vector<int> part_of(from.nodes.size(), unseen), place(from.nodes.size(), unseen);
  for (const auto& g : from.groups) {
    const auto own = g.dimension == 3 ? blocks.find(g.tag) : blocks.end();
    if (own == blocks.end()) continue;
    const int part = mesh.add_part(name_of(g));
    const std::size_t first = mesh.nodes.size();
    for (const MshBlock* b : own->second)
      for (const int n : b->nodes) {
        int& owner = part_of[index(n)];
        if (owner != unseen && owner != part)
          throw std::invalid_argument(
              "mesh: parts '" + mesh.parts[index(owner)] + "' and '" + mesh.parts[index(part)] +
              "' share a node; parts act on each other through contact alone, so each "
              "needs nodes of its own");
        owner = part;
      }
    for (std::size_t n = 0; n < from.nodes.size(); ++n) {
      if (part_of[n] != part) continue;
      place[n] = static_cast<int>(mesh.nodes.size());
      const auto& at = from.nodes[n];
      mesh.nodes.push_back({at[0] * metres, at[1] * metres, at[2] * metres});
    }
    for (const MshBlock* b : own->second)
      for (int e = 0; e < b->elements(); ++e) {
        SolidCell cell;
        cell.part = part;
        for (int k = 0; k < b->nodes_per_element; ++k)
          cell.nodes[index(k)] = place[index(b->nodes[index(e * b->nodes_per_element + k)])];
        mesh.cells.push_back(cell);
      }
    check_extent(mesh, first, mesh.parts[index(part)]);
  }
  check_mesh(mesh);
  return mesh;
}

}  // namespace powbench::sim
