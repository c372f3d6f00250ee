#include "sim/magnetics/space/grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <string>

namespace powbench::sim::space {
namespace {

/// Appends the positions after `a` up to and including `b`: cells grow from both ends and meet inside.
void fill(std::vector<double>& line, const GridMark& a, const GridMark& b, double growth, double largest) {
  const double length = b.at - a.at;
  std::vector<double> left, right;
  double left_next = std::min(a.size, largest), right_next = std::min(b.size, largest), sum = 0;
  while (sum < length * (1 - 1e-9)) {
    double& next = left_next <= right_next ? left_next : right_next;
    const double half = 0.5 * next;
    if (sum + half > length && !(left.empty() && right.empty())) break;  // the others stretch instead
    (left_next <= right_next ? left : right).push_back(next);
    sum += next;
    next = std::min(next * growth, largest);
  }
  left.insert(left.end(), right.rbegin(), right.rend());
  const double scale = length / sum;
  double at = a.at;
  for (std::size_t k = 0; k + 1 < left.size(); ++k) line.push_back(at += left[k] * scale);
  line.push_back(b.at);
}

constexpr signed char corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
/// Ends of the edges, then corners opposite each other on the faces, then the centre: gmsh's order.
constexpr signed char middle[19][2] = {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6},
                                       {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}, {0, 2}, {0, 5},
                                       {0, 7}, {1, 6}, {2, 7}, {4, 6}, {0, 6}};

/// Nodes on the lattice of half cells, made when first asked for.
struct Lattice {
  const std::vector<double>* line[3];
  std::size_t span[3];
  std::vector<int> node;
  Mesh& mesh;

  double at(int axis, std::size_t k) const {
    const auto& l = *line[axis];
    return k % 2 == 0 ? l[k / 2] : 0.5 * (l[k / 2] + l[k / 2 + 1]);
  }

  int operator()(std::size_t i, std::size_t j, std::size_t k) {
    int& n = node[(k * span[1] + j) * span[0] + i];
    if (n < 0) {
      n = static_cast<int>(mesh.nodes.size());
      mesh.nodes.push_back({at(0, i), at(1, j), at(2, k)});
    }
    return n;
  }
};

}  // namespace

std::vector<double> graded_line(const std::vector<GridMark>& marks, double growth, double largest) {
  if (marks.size() < 2 || !(growth > 1) || !(largest > 0))
    throw std::invalid_argument(
        "grid: at least 2 marks, growth above 1 and a largest size above 0 are needed");
  for (std::size_t k = 0; k < marks.size(); ++k) {
    if (!(marks[k].size > 0))
      throw std::invalid_argument("grid: size " + std::to_string(marks[k].size) + " of mark " +
                                  std::to_string(k) + ", allowed above 0");
    if (k > 0 && !(marks[k].at > marks[k - 1].at))
      throw std::invalid_argument("grid: mark " + std::to_string(k) + " at " + std::to_string(marks[k].at) +
                                  " m does not lie above the one before, " + std::to_string(marks[k - 1].at) +
                                  " m");
  }
  std::vector<double> line{marks.front().at};
  for (std::size_t k = 1; k < marks.size(); ++k) fill(line, marks[k - 1], marks[k], growth, largest);
  return line;
}

Mesh grid_mesh(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z,
               Cell cell, const std::function<int(const Vec3&)>& region) {
  assert(cell == Cell::hex8 || cell == Cell::hex20 || cell == Cell::hex27);
  Mesh mesh;
  mesh.cell = cell;
  Lattice lattice{{&x, &y, &z}, {2 * x.size() - 1, 2 * y.size() - 1, 2 * z.size() - 1}, {}, mesh};
  lattice.node.assign(lattice.span[0] * lattice.span[1] * lattice.span[2], -1);
  const int per = mesh.per_cell();
  for (std::size_t k = 0; k + 1 < z.size(); ++k)
    for (std::size_t j = 0; j + 1 < y.size(); ++j)
      for (std::size_t i = 0; i + 1 < x.size(); ++i) {
        const int r = region({0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1]), 0.5 * (z[k] + z[k + 1])});
        if (r < 0) continue;
        mesh.region.push_back(r);
        for (int a = 0; a < per; ++a) {
          const auto& p = corner[a < 8 ? a : middle[a - 8][0]];
          const auto& q = corner[a < 8 ? a : middle[a - 8][1]];
          mesh.cells.push_back(lattice(2 * i + p[0] + q[0], 2 * j + p[1] + q[1], 2 * k + p[2] + q[2]));
        }
      }
  return mesh;
}

void map_nodes(Mesh& mesh, const std::function<Vec3(const Vec3&)>& map) {
  for (auto& n : mesh.nodes) n = map(n);
}

}  // namespace powbench::sim::space
