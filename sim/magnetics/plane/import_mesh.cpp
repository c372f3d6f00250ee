#include "sim/magnetics/plane/import_mesh.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace powbench::sim {
namespace {

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

std::string place_text(const Mesh& m, int vertex) {
  char text[80];
  std::snprintf(text, sizeof text, "x = %.4g, y = %.4g mm", m.x[index(vertex)] * 1e3,
                m.y[index(vertex)] * 1e3);
  return text;
}

/// The region of a block of surface elements.
int region_of(const MshBlock& block, const std::map<int, int>& region_of_group) {
  const auto where = "mesh: surface " + std::to_string(block.entity);
  int region = -1;
  for (const int g : block.groups) {
    const auto found = region_of_group.find(g);
    if (found == region_of_group.end() || found->second == region) continue;
    if (region >= 0)
      throw std::invalid_argument(where + " belongs to two physical groups with a material, allowed one");
    region = found->second;
  }
  if (region < 0)
    throw std::invalid_argument(where + " belongs to none of the physical groups that have a material");
  return region;
}

}  // namespace

Mesh import_plane_mesh(const MshMesh& from, double metres, const std::map<int, int>& region_of_group,
                       const std::vector<int>& zero_groups) {
  if (!(metres > 0))
    throw std::invalid_argument("mesh: " + std::to_string(metres) + " m a unit, allowed above 0");
  Mesh mesh;
  std::vector<int> vertex(from.nodes.size(), -1);
  const auto take = [&](int node) {
    int& v = vertex[index(node)];
    if (v >= 0) return v;
    v = static_cast<int>(mesh.x.size());
    mesh.x.push_back(from.nodes[index(node)][0] * metres);
    mesh.y.push_back(from.nodes[index(node)][1] * metres);
    return v;
  };
  for (const auto& block : from.blocks) {
    if (msh_dimension(block.shape) != 2) continue;
    const int region = region_of(block, region_of_group);
    for (int e = 0; e < block.elements(); ++e) {
      const int* n = block.nodes.data() + e * block.nodes_per_element;
      const int a = take(n[0]), b = take(n[1]), c = take(n[2]);
      mesh.triangle.push_back({a, b, c});
      if (block.shape == MshShape::quadrangle) mesh.triangle.push_back({a, c, take(n[3])});
    }
    mesh.region.resize(mesh.triangle.size(), region);
  }
  if (mesh.triangle.empty()) throw std::invalid_argument("mesh: no triangles or quadrangles");
  mesh.zero.assign(mesh.x.size(), 0);
  std::map<std::pair<int, int>, int> triangles;
  for (const auto& t : mesh.triangle)
    for (std::size_t k = 0; k < 3; ++k) ++triangles[std::minmax(t[k], t[(k + 1) % 3])];
  for (const auto& block : from.blocks) {
    if (msh_dimension(block.shape) != 1) continue;
    const bool zero = std::any_of(block.groups.begin(), block.groups.end(), [&](int g) {
      return std::find(zero_groups.begin(), zero_groups.end(), g) != zero_groups.end();
    });
    if (!zero) continue;
    for (int e = 0; e < block.elements(); ++e) {
      const int* n = block.nodes.data() + e * block.nodes_per_element;  // the ends of a line come first
      const int a = vertex[index(n[0])], b = vertex[index(n[1])];
      const auto edge = triangles.find(std::minmax(a, b));
      if (edge != triangles.end() && edge->second > 1)
        throw std::invalid_argument("mesh: A = 0 on a line inside the mesh, at " + place_text(mesh, a) +
                                    ", which no flux could cross; allowed on outer edges and around holes");
      for (const int v : {a, b})
        if (v >= 0) mesh.zero[index(v)] = 1;
    }
  }
  check_mesh(mesh);
  return mesh;
}

}  // namespace powbench::sim
