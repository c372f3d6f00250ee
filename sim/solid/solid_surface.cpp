#include "sim/solid/solid_surface.h"

#include <algorithm>
#include <map>

namespace powbench::sim {
namespace {

constexpr int hex_faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                 {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
constexpr int tet_faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::array<Vec3, 4> places(const SolidMesh& mesh, const Facet& f) {
  std::array<Vec3, 4> p{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(f.corners()); ++k)
    p[k] = mesh.nodes[static_cast<std::size_t>(f.nodes[k])];
  return p;
}

std::vector<Facet> skin(const SolidMesh& mesh, int part) {
  std::map<std::array<int, 4>, std::pair<Facet, int>>
      faces;  // key: sorted corners; order fixes the numbering
  for (std::size_t e = 0; e < mesh.cells.size(); ++e) {
    const SolidCell& cell = mesh.cells[e];
    if (cell.part != part) continue;
    for (int k = 0; k < (cell.is_hex() ? 6 : 4); ++k) {
      Facet f;
      f.cell = static_cast<int>(e);
      for (std::size_t c = 0; c < (cell.is_hex() ? 4u : 3u); ++c)
        f.nodes[c] = cell.nodes[static_cast<std::size_t>(cell.is_hex() ? hex_faces[k][c] : tet_faces[k][c])];
      auto key = f.nodes;
      std::sort(key.begin(), key.end());
      const auto [place, fresh] = faces.try_emplace(key, f, 0);
      ++place->second.second;
    }
  }
  std::vector<Facet> out;
  for (const auto& [key, face] : faces)
    if (face.second == 1) out.push_back(face.first);
  return out;
}

void find_edges(const SolidMesh& mesh, SolidSurface& s) {
  std::map<std::pair<int, int>, std::vector<int>> meeting;
  for (std::size_t f = 0; f < s.facets.size(); ++f) {
    const auto n = static_cast<std::size_t>(s.facets[f].corners());
    for (std::size_t k = 0; k < n; ++k) {
      const int a = s.facets[f].nodes[k], b = s.facets[f].nodes[(k + 1) % n];
      meeting[{std::min(a, b), std::max(a, b)}].push_back(static_cast<int>(f));
    }
  }
  for (const auto& [edge, both] : meeting) {
    if (both.size() != 2) continue;
    const Facet& left = s.facets[static_cast<std::size_t>(both[0])];
    const Facet& right = s.facets[static_cast<std::size_t>(both[1])];
    const auto pl = places(mesh, left), pr = places(mesh, right);
    const Vec3 nl = unit(facet_normal(pl, left.corners())), nr = unit(facet_normal(pr, right.corners()));
    if (dot(nl, nr) > 0.94) continue;
    Vec3 middle;
    for (std::size_t k = 0; k < static_cast<std::size_t>(right.corners()); ++k)
      middle += 1.0 / right.corners() * pr[k];
    if (dot(nl, middle - mesh.nodes[static_cast<std::size_t>(edge.first)]) >= 0) continue;  // concave
    s.edges.push_back({edge.first, edge.second, both[0], both[1]});
  }
}

}  // namespace

Vec3 facet_normal(const std::array<Vec3, 4>& p, int count) {
  return count == 4 ? cross(p[2] - p[0], p[3] - p[1]) : cross(p[1] - p[0], p[2] - p[0]);
}

int SolidSurface::place_of(int node) const {
  return static_cast<int>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
}

double SolidSurface::area_along(std::size_t place, const Vec3& against,
                                const std::function<Vec3(int)>& at) const {
  double sum = 0;
  for (const int f : facets_at[place]) {
    const Facet& facet = facets[static_cast<std::size_t>(f)];
    std::array<Vec3, 4> p{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(facet.corners()); ++k) p[k] = at(facet.nodes[k]);
    sum -= std::min(0.0, 0.5 * dot(facet_normal(p, facet.corners()), against)) / facet.corners();
  }
  return sum;
}

SolidSurface surface_of(const SolidMesh& mesh, int part, const SolidMaterial& material) {
  SolidSurface s;
  s.part = part;
  s.facets = skin(mesh, part);
  for (const Facet& f : s.facets)
    s.nodes.insert(s.nodes.end(), f.nodes.begin(), f.nodes.begin() + f.corners());
  std::sort(s.nodes.begin(), s.nodes.end());
  s.nodes.erase(std::unique(s.nodes.begin(), s.nodes.end()), s.nodes.end());
  s.areas.assign(s.nodes.size(), 0.0);
  s.stiffness.assign(s.nodes.size(), 0.0);
  s.facets_at.resize(s.nodes.size());
  for (std::size_t k = 0; k < s.facets.size(); ++k) {
    Facet& f = s.facets[k];
    const double area = 0.5 * norm(facet_normal(places(mesh, f), f.corners()));
    f.stiffness =
        material.wave_modulus() * area / cell_volume(mesh, mesh.cells[static_cast<std::size_t>(f.cell)]);
    for (std::size_t c = 0; c < static_cast<std::size_t>(f.corners()); ++c) {
      const auto n = static_cast<std::size_t>(s.place_of(f.nodes[c]));
      s.stiffness[n] += f.stiffness;
      s.facets_at[n].push_back(static_cast<int>(k));
    }
  }
  for (std::size_t n = 0; n < s.nodes.size(); ++n)
    for (const int f : s.facets_at[n]) {
      const Facet& facet = s.facets[static_cast<std::size_t>(f)];
      const Vec3 along = unit(facet_normal(places(mesh, facet), facet.corners()));
      s.areas[n] = std::max(s.areas[n], s.area_along(n, -along, [&](int node) {
        return mesh.nodes[static_cast<std::size_t>(node)];
      }));
    }
  for (std::size_t n = 0; n < s.nodes.size(); ++n)
    s.stiffness[n] /= static_cast<double>(s.facets_at[n].size());
  find_edges(mesh, s);
  return s;
}

}  // namespace powbench::sim
