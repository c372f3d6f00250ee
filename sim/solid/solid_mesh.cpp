#include "sim/solid/solid_mesh.h"

#include <stdexcept>

#include "sim/solid/hex_shape.h"

namespace powbench::sim {
namespace {

double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(b - a, cross(c - a, d - a)) / 6;
}

/// Smallest Jacobian of a hexahedron at its corners, times 8.
double smallest_corner(const std::array<Vec3, 8>& x) {
  static constexpr int next[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                     {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
  double least = 1e300;
  for (int a = 0; a < 8; ++a) {
    const auto& n = next[a];
    const auto from = [&](int k) {
      return x[static_cast<std::size_t>(n[k])] - x[static_cast<std::size_t>(a)];
    };
    least = std::fmin(least, dot(from(0), cross(from(1), from(2))));
  }
  return least;
}

}  // namespace

std::array<Vec3, 8> corners_of(const SolidMesh& mesh, const SolidCell& cell) {
  std::array<Vec3, 8> x{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(cell.corners()); ++a)
    x[a] = mesh.nodes[static_cast<std::size_t>(cell.nodes[a])];
  return x;
}

int SolidMesh::add_part(const std::string& name) {
  parts.push_back(name);
  return static_cast<int>(parts.size()) - 1;
}

void add_grid(SolidMesh& mesh, int part, const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& z, const std::function<bool(int, int, int)>& filled) {
  const std::size_t nx = x.size(), ny = y.size(), nz = z.size();
  std::vector<int> number(nx * ny * nz, -1);
  const auto place = [&](std::size_t i, std::size_t j, std::size_t k) -> int& {
    return number[i + nx * (j + ny * k)];
  };
  static constexpr int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                       {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const auto each_cell = [&](const auto& visit) {
    for (std::size_t k = 0; k + 1 < nz; ++k)
      for (std::size_t j = 0; j + 1 < ny; ++j)
        for (std::size_t i = 0; i + 1 < nx; ++i)
          if (filled(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k))) visit(i, j, k);
  };
  each_cell([&](std::size_t i, std::size_t j, std::size_t k) {
    for (const auto& c : corner)
      place(i + static_cast<std::size_t>(c[0]), j + static_cast<std::size_t>(c[1]),
            k + static_cast<std::size_t>(c[2])) = 0;
  });
  for (std::size_t k = 0; k < nz; ++k)  // nodes in the order of the grid keep neighbours close in memory
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i)
        if (place(i, j, k) == 0) {
          place(i, j, k) = static_cast<int>(mesh.nodes.size());
          mesh.nodes.push_back({x[i], y[j], z[k]});
        }
  each_cell([&](std::size_t i, std::size_t j, std::size_t k) {
    SolidCell cell;
    cell.part = part;
    for (std::size_t a = 0; a < 8; ++a)
      cell.nodes[a] =
          place(i + static_cast<std::size_t>(corner[a][0]), j + static_cast<std::size_t>(corner[a][1]),
                k + static_cast<std::size_t>(corner[a][2]));
    mesh.cells.push_back(cell);
  });
}

int add_box(SolidMesh& mesh, int part, const Vec3& lo, const Vec3& hi, int nx, int ny, int nz) {
  if (nx < 1 || ny < 1 || nz < 1) throw std::invalid_argument("box: each direction needs at least one cell");
  const int first = static_cast<int>(mesh.nodes.size());
  const auto planes = [](double from, double to, int n) {
    std::vector<double> all;
    for (int i = 0; i <= n; ++i) all.push_back(i == n ? to : from + (to - from) * i / n);
    return all;
  };
  add_grid(mesh, part, planes(lo.x, hi.x, nx), planes(lo.y, hi.y, ny), planes(lo.z, hi.z, nz),
           [](int, int, int) { return true; });
  return first;
}

void map_nodes(SolidMesh& mesh, int first, const std::function<Vec3(const Vec3&)>& map) {
  for (std::size_t n = static_cast<std::size_t>(first); n < mesh.nodes.size(); ++n)
    mesh.nodes[n] = map(mesh.nodes[n]);
}

double cell_volume(const std::array<Vec3, 8>& x, bool hex) {
  return hex ? hex_shape(x).volume : tet_volume(x[0], x[1], x[2], x[3]);
}

double cell_volume(const SolidMesh& mesh, const SolidCell& cell) {
  return cell_volume(corners_of(mesh, cell), cell.is_hex());
}

double gradient_square(const std::array<Vec3, 8>& x, bool hex) {
  double square = 0;
  if (hex) {
    for (const Vec3& beta : hex_shape(x).beta) square += 8 * dot(beta, beta);
    return square;
  }
  const Vec3 d1 = x[1] - x[0], d2 = x[2] - x[0], d3 = x[3] - x[0];
  const Vec3 b1 = cross(d2, d3), b2 = cross(d3, d1), b3 = cross(d1, d2), b0 = b1 + b2 + b3;
  return (dot(b0, b0) + dot(b1, b1) + dot(b2, b2) + dot(b3, b3)) / 36;
}

void check_mesh(const SolidMesh& mesh) {
  const auto bad = [](std::size_t cell, const std::string& what) {
    throw std::invalid_argument("mesh cell " + std::to_string(cell) + ": " + what);
  };
  for (std::size_t e = 0; e < mesh.cells.size(); ++e) {
    const SolidCell& cell = mesh.cells[e];
    if (cell.part < 0 || cell.part >= static_cast<int>(mesh.parts.size()))
      bad(e, "names a part that does not exist");
    for (std::size_t a = 0; a < static_cast<std::size_t>(cell.corners()); ++a)
      if (cell.nodes[a] < 0 || cell.nodes[a] >= static_cast<int>(mesh.nodes.size()))
        bad(e, "names a node that does not exist");
    const double volume = cell_volume(mesh, cell);
    if (!(volume > 0)) bad(e, "volume " + std::to_string(volume) + " m3, must be > 0");
    if (!cell.is_hex()) continue;
    if (!(smallest_corner(corners_of(mesh, cell)) > 0))
      bad(e, "is folded at a corner, the Jacobian must be > 0 at all eight");
  }
}

}  // namespace powbench::sim
