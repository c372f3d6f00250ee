#include "sim/magnetics/space/mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace powbench::sim::space {
namespace {

/// Nodes of the 27-node hexahedron on the reference cube, gmsh's order; the first 8 and 20 are those of the lesser
/// ones.
constexpr signed char hex_nodes[27][3] = {
    {-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
    {-1, 1, 1},   {0, -1, -1}, {-1, 0, -1}, {-1, -1, 0}, {1, 0, -1},  {1, -1, 0}, {0, 1, -1},
    {1, 1, 0},    {-1, 1, 0},  {0, -1, 1},  {-1, 0, 1},  {1, 0, 1},   {0, 1, 1},  {0, 0, -1},
    {0, -1, 0},   {-1, 0, 0},  {1, 0, 0},   {0, 1, 0},   {0, 0, 1},   {0, 0, 0}};

constexpr int tet_edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}};

/// One factor of a product and its derivative.
struct Factor {
  double value, slope;
};

Factor linear(int at, double x) {
  return {0.5 * (1 + at * x), 0.5 * at};
}

Factor bubble(double x) {
  return {1 - x * x, -2 * x};
}

Factor quadratic(int at, double x) {
  return at == 0 ? bubble(x) : Factor{0.5 * x * (x + at), x + 0.5 * at};
}

void product(const Factor (&f)[3], double& value, Vec3& slope) {
  value = f[0].value * f[1].value * f[2].value;
  slope = {f[0].slope * f[1].value * f[2].value, f[0].value * f[1].slope * f[2].value,
           f[0].value * f[1].value * f[2].slope};
}

/// Corner and edge functions of the 20-node hexahedron.
void serendipity(const signed char (&at)[3], const Vec3& xi, double& value, Vec3& slope) {
  Factor f[3];
  bool corner = true;
  for (int k = 0; k < 3; ++k) {
    f[k] = at[k] == 0 ? bubble(xi[k]) : linear(at[k], xi[k]);
    corner = corner && at[k] != 0;
  }
  product(f, value, slope);
  if (!corner) return;
  const double s = at[0] * xi[0] + at[1] * xi[1] + at[2] * xi[2] - 2;
  for (int k = 0; k < 3; ++k) slope[k] = slope[k] * s + value * at[k];
  value *= s;
}

void hexahedron(Cell cell, const Vec3& xi, int node, double& value, Vec3& slope) {
  const auto& at = hex_nodes[node];
  if (cell == Cell::hex20) return serendipity(at, xi, value, slope);
  Factor f[3];
  for (int k = 0; k < 3; ++k) f[k] = cell == Cell::hex8 ? linear(at[k], xi[k]) : quadratic(at[k], xi[k]);
  product(f, value, slope);
}

void tetrahedron(Cell cell, const Vec3& xi, int node, double& value, Vec3& slope) {
  const double l[4] = {1 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]};
  constexpr Vec3 dl[4] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (node < 4) {
    const bool first = cell == Cell::tet4;
    value = first ? l[node] : l[node] * (2 * l[node] - 1);
    for (int k = 0; k < 3; ++k) slope[k] = (first ? 1 : 4 * l[node] - 1) * dl[node][k];
    return;
  }
  const auto [a, b] = tet_edges[node - 4];
  value = 4 * l[a] * l[b];
  for (int k = 0; k < 3; ++k) slope[k] = 4 * (l[a] * dl[b][k] + l[b] * dl[a][k]);
}

bool is_hex(Cell cell) {
  return cell == Cell::hex8 || cell == Cell::hex20 || cell == Cell::hex27;
}

std::vector<Vec3> reference_nodes(Cell cell, int count) {
  constexpr Vec3 corner[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> nodes;
  for (int a = 0; a < count; ++a) {
    if (is_hex(cell)) {
      nodes.push_back({double(hex_nodes[a][0]), double(hex_nodes[a][1]), double(hex_nodes[a][2])});
      continue;
    }
    const Vec3& p = corner[a < 4 ? a : tet_edges[a - 4][0]];
    const Vec3& q = corner[a < 4 ? a : tet_edges[a - 4][1]];
    nodes.push_back({0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])});
  }
  return nodes;
}

CellRule make_rule(Cell cell) {
  constexpr int counts[] = {8, 20, 27, 4, 10};
  CellRule rule;
  rule.nodes = counts[static_cast<int>(cell)];
  rule.node = reference_nodes(cell, rule.nodes);
  const double root = std::sqrt(0.6);
  const double gauss_x[3] = {-root, 0, root};
  constexpr double gauss_w[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  for (int i = 0; i < 27; ++i) {
    const int a = i % 3, b = i / 3 % 3, c = i / 9;
    Vec3 xi{gauss_x[a], gauss_x[b], gauss_x[c]};
    double w = gauss_w[a] * gauss_w[b] * gauss_w[c];
    if (!is_hex(cell)) {  // the cube collapsed to a tetrahedron
      const double u = 0.5 * (1 + xi[0]), v = 0.5 * (1 + xi[1]), t = 0.5 * (1 + xi[2]);
      xi = {u, v * (1 - u), t * (1 - u) * (1 - v)};
      w *= (1 - u) * (1 - u) * (1 - v) / 8;
    }
    std::vector<double> value;
    std::vector<Vec3> slope;
    cell_shape(cell, xi, value, slope);
    rule.weight.push_back(w);
    rule.value.insert(rule.value.end(), value.begin(), value.end());
    rule.slope.insert(rule.slope.end(), slope.begin(), slope.end());
  }
  rule.points = static_cast<int>(rule.weight.size());
  return rule;
}

}  // namespace

void cell_shape(Cell cell, const Vec3& xi, std::vector<double>& value, std::vector<Vec3>& slope) {
  constexpr int counts[] = {8, 20, 27, 4, 10};
  const int n = counts[static_cast<int>(cell)];
  value.resize(static_cast<std::size_t>(n));
  slope.resize(static_cast<std::size_t>(n));
  for (int a = 0; a < n; ++a) {
    if (is_hex(cell))
      hexahedron(cell, xi, a, value[a], slope[a]);
    else
      tetrahedron(cell, xi, a, value[a], slope[a]);
  }
}

const CellRule& cell_rule(Cell cell) {
  static const CellRule rules[] = {make_rule(Cell::hex8), make_rule(Cell::hex20), make_rule(Cell::hex27),
                                   make_rule(Cell::tet4), make_rule(Cell::tet10)};
  return rules[static_cast<int>(cell)];
}

double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a);
}

Mesh straight_tetrahedra(const Mesh& from) {
  const auto per = static_cast<std::size_t>(from.per_cell());
  Mesh out{Cell::tet10, {}, {}, from.region};
  std::vector<int> number(from.nodes.size(), -1);
  std::vector<std::array<int, 4>> corners(from.region.size());
  for (std::size_t c = 0; c < corners.size(); ++c)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto old = static_cast<std::size_t>(from.cells[c * per + k]);
      if (number[old] < 0) {
        number[old] = static_cast<int>(out.nodes.size());
        out.nodes.push_back(from.nodes[old]);
      }
      corners[c][k] = number[old];
    }
  const auto node = [&](int n) { return out.nodes[static_cast<std::size_t>(n)]; };
  std::map<std::pair<int, int>, int> middles;
  for (auto& v : corners) {
    if (six_volumes(node(v[0]), node(v[1]), node(v[2]), node(v[3])) < 0) std::swap(v[2], v[3]);
    out.cells.insert(out.cells.end(), v.begin(), v.end());
    for (const auto& [a, b] : tet_edges) {
      const std::pair<int, int> ends =
          std::minmax(v[static_cast<std::size_t>(a)], v[static_cast<std::size_t>(b)]);
      const auto [found, fresh] = middles.try_emplace(ends, static_cast<int>(out.nodes.size()));
      if (fresh) out.nodes.push_back(0.5 * (node(ends.first) + node(ends.second)));
      out.cells.push_back(found->second);
    }
  }
  return out;
}

void set_middles(const Mesh& mesh, std::vector<double>& values) {
  const auto value = [&](std::size_t c, int k) -> double& {
    return values[static_cast<std::size_t>(mesh.cells[10 * c + static_cast<std::size_t>(k)])];
  };
  for (std::size_t c = 0; c < mesh.region.size(); ++c)
    for (int e = 0; e < 6; ++e)
      value(c, 4 + e) = 0.5 * (value(c, tet_edges[e][0]) + value(c, tet_edges[e][1]));
}

double cell_gradients(const Mesh& mesh, int c, const Vec3* slope, Vec3* gradient) {
  const int n = mesh.per_cell();
  const int* cell = mesh.cells.data() + static_cast<std::ptrdiff_t>(c) * n;
  double j[3][3] = {};  // dx_r/dxi_k
  for (int a = 0; a < n; ++a) {
    const Vec3& x = mesh.nodes[static_cast<std::size_t>(cell[a])];
    for (int r = 0; r < 3; ++r)
      for (int k = 0; k < 3; ++k) j[r][k] += x[r] * slope[a][k];
  }
  double cofactor[3][3];
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k < 3; ++k) {
      const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      cofactor[r][k] = j[r1][k1] * j[r2][k2] - j[r1][k2] * j[r2][k1];
    }
  const double det = j[0][0] * cofactor[0][0] + j[0][1] * cofactor[0][1] + j[0][2] * cofactor[0][2];
  if (!(det > 0))
    throw std::invalid_argument("mesh: cell " + std::to_string(c) +
                                " is flat or turned inside out (Jacobian " + std::to_string(det) +
                                ", allowed above 0)");
  for (int a = 0; a < n; ++a)
    for (int r = 0; r < 3; ++r)
      gradient[a][r] =
          (cofactor[r][0] * slope[a][0] + cofactor[r][1] * slope[a][1] + cofactor[r][2] * slope[a][2]) / det;
  return det;
}

}  // namespace powbench::sim::space
