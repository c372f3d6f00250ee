#pragma once

#include <cmath>

#include "sim/solid/explicit_solid.h"

/// Bodies that several tests use.

namespace powbench::sim::cases {

/// Seven hexahedra in a cube: a small one inside, skewed, and one on each of its faces.
inline SolidMesh seven_hexahedra() {
  SolidMesh m;
  const int part = m.add_part("cube");
  const Vec3 outer[8] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                         {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const Vec3 inner[8] = {{.25, .34, .26}, {.74, .29, .31}, {.69, .66, .24}, {.30, .72, .33},
                         {.32, .25, .68}, {.68, .31, .72}, {.75, .70, .66}, {.27, .68, .73}};
  for (const auto& p : outer) m.nodes.push_back(p);
  for (const auto& p : inner) m.nodes.push_back(p);
  const int faces[6][4] = {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1},
                           {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
  for (const auto& f : faces) {
    SolidCell c;
    c.part = part;
    for (std::size_t k = 0; k < 4; ++k) {
      c.nodes[k] = f[k];
      c.nodes[4 + k] = f[k] + 8;
    }
    m.cells.push_back(c);
  }
  m.cells.push_back({{8, 9, 10, 11, 12, 13, 14, 15}, part});
  return m;
}

/// Eight distorted cells around the node 13, six tetrahedra around a diagonal each.
inline SolidMesh distorted_eight() {
  SolidMesh m;
  add_box(m, m.add_part("cube"), {0, 0, 0}, {1, 1, 1}, 2, 2, 2);
  m.nodes[13] += Vec3{.11, -.07, .05};
  m.nodes[4] += Vec3{.08, .05, 0};
  m.nodes[14] += Vec3{0, .06, -.09};
  return m;
}

/// Six tetrahedra around the diagonal of each cell; neighbours fit where the cells are numbered alike.
inline SolidMesh tetrahedra_of(const SolidMesh& hexes) {
  static constexpr std::size_t cut[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                            {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  SolidMesh m;
  m.nodes = hexes.nodes;
  m.parts = hexes.parts;
  for (const auto& h : hexes.cells)
    for (const auto& c : cut) {
      SolidCell t;
      t.part = h.part;
      for (std::size_t k = 0; k < 4; ++k) t.nodes[k] = h.nodes[c[k]];
      m.cells.push_back(t);
    }
  return m;
}

/// Displacement (4 a node) of the linear field u = G x.
inline std::vector<double> linear_field(const SolidMesh& m, const double (&g)[3][3]) {
  std::vector<double> u(4 * m.nodes.size(), 0.0);
  for (std::size_t n = 0; n < m.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) u[4 * n + i] += g[i][static_cast<std::size_t>(j)] * m.nodes[n][j];
  return u;
}

/// Largest difference of any cell's stress to the first one's, relative.
inline double stress_scatter(const CellBatches& cells, const std::vector<double>& u) {
  const auto s = cells.stresses(u);
  double worst = 0, size = 0;
  for (const auto& c : s)
    for (std::size_t k = 0; k < 6; ++k) {
      worst = std::max(worst, std::fabs(c.stress[k] - s[0].stress[k]));
      size = std::max(size, std::fabs(c.stress[k]));
    }
  return worst / size;
}

inline SolidMaterial material(double young, double poisson, double density) {
  SolidMaterial m;
  m.young = young;
  m.poisson = poisson;
  m.density = density;
  return m;
}

}  // namespace powbench::sim::cases
