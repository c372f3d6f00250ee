#include "sim/magnetics/space/import.h"

#include <optional>
#include <stdexcept>
#include <string>

namespace powbench::sim::space {
namespace {

std::optional<Cell> cell_of(const MshBlock& block) {
  switch (block.nodes_per_element) {
    case 4:
      return Cell::tet4;
    case 8:
      return Cell::hex8;
    case 10:
      return Cell::tet10;
    case 20:
      return Cell::hex20;
    case 27:
      return Cell::hex27;
    default:
      return std::nullopt;
  }
}

}  // namespace

Mesh import_mesh(const MshMesh& from, double metres, const std::map<int, int>& region_of_group) {
  if (!(metres > 0))
    throw std::invalid_argument("mesh: " + std::to_string(metres) + " m a unit, allowed above 0");
  Mesh mesh;
  for (const auto& n : from.nodes) mesh.nodes.push_back({n[0] * metres, n[1] * metres, n[2] * metres});
  for (const auto& block : from.blocks) {
    if (msh_dimension(block.shape) != 3) continue;
    const auto cell = cell_of(block);
    if (!mesh.region.empty() && cell != mesh.cell)
      throw std::invalid_argument("mesh: two kinds of volume cells, allowed one");
    mesh.cell = *cell;
    std::optional<int> region;
    for (const int g : block.groups)
      if (const auto found = region_of_group.find(g); found != region_of_group.end()) region = found->second;
    if (!region)
      throw std::invalid_argument("mesh: volume " + std::to_string(block.entity) +
                                  " belongs to none of the physical groups that have a medium");
    mesh.cells.insert(mesh.cells.end(), block.nodes.begin(), block.nodes.end());
    mesh.region.insert(mesh.region.end(), static_cast<std::size_t>(block.elements()), *region);
  }
  if (mesh.region.empty()) throw std::invalid_argument("mesh: no tetrahedra or hexahedra");
  return mesh;
}

}  // namespace powbench::sim::space
