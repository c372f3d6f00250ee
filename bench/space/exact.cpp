#include "bench/space/exact.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/magnetics/space/grid.h"

namespace powbench::bench {
namespace {

using sim::Vec3;
constexpr double mu0 = 4e-7 * std::numbers::pi;
constexpr double quarter = std::numbers::pi / 4;

std::vector<double> even(int cells) {
  std::vector<double> line;
  for (int k = 0; k <= cells; ++k) line.push_back(static_cast<double>(k) / cells);
  return line;
}

/// The first axis becomes `axis`, the others follow in turn: keeps the orientation.
Vec3 turned(const Vec3& p, int axis) {
  Vec3 q;
  for (int r = 0; r < 3; ++r) q[(r + axis) % 3] = p[r];
  return q;
}

}  // namespace

sim::space::Mesh join_meshes(const std::vector<sim::space::Mesh>& parts, double tolerance) {
  sim::space::Mesh out;
  std::map<std::array<long long, 3>, std::vector<int>> buckets;  // cubes of ten tolerances
  const auto bucket = [&](const Vec3& p) {
    std::array<long long, 3> key;
    for (int r = 0; r < 3; ++r) key[r] = std::llround(p[r] / (10 * tolerance));
    return key;
  };
  const auto find = [&](const Vec3& p) {
    const auto centre = bucket(p);
    for (int k = 0; k < 27; ++k) {
      const auto found =
          buckets.find({centre[0] + k % 3 - 1, centre[1] + k / 3 % 3 - 1, centre[2] + k / 9 - 1});
      if (found == buckets.end()) continue;
      for (const int n : found->second) {
        const auto& q = out.nodes[static_cast<std::size_t>(n)];
        if (std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < tolerance) return n;
      }
    }
    return -1;
  };
  for (const auto& part : parts) {
    assert(part.cell == parts.front().cell);
    out.cell = part.cell;
    std::vector<int> index;
    for (const auto& p : part.nodes) {
      int n = find(p);
      if (n < 0) {
        n = static_cast<int>(out.nodes.size());
        out.nodes.push_back(p);
        buckets[bucket(p)].push_back(n);
      }
      index.push_back(n);
    }
    for (const int n : part.cells) out.cells.push_back(index[static_cast<std::size_t>(n)]);
    out.region.insert(out.region.end(), part.region.begin(), part.region.end());
  }
  return out;
}

sim::space::Mesh ball_mesh(const std::vector<double>& radius, int cells, sim::space::Cell cell) {
  const double cube = 0.5 * radius.front();  // edge of the cube in the middle
  const auto line = even(cells);
  std::vector<sim::space::Mesh> parts;
  parts.push_back(sim::space::grid_mesh(line, line, line, cell, [](const Vec3&) { return 0; }));
  sim::space::map_nodes(parts.back(), [&](const Vec3& p) {
    return Vec3{cube * p[0], cube * p[1], cube * p[2]};
  });
  for (std::size_t shell = 0; shell < radius.size(); ++shell) {
    const double inner = shell == 0 ? 0 : radius[shell - 1], outer = radius[shell];
    // thick shells in layers of the same shape
    const int layers =
        shell == 0 ? cells
                   : std::max(cells, static_cast<int>(std::lround(1.6 * cells * std::log(outer / inner))));
    for (int axis = 0; axis < 3; ++axis) {
      parts.push_back(sim::space::grid_mesh(even(layers), line, line, cell,
                                            [&](const Vec3&) { return static_cast<int>(shell); }));
      sim::space::map_nodes(parts.back(), [&](const Vec3& p) {
        Vec3 direction{1, std::tan(quarter * p[1]), std::tan(quarter * p[2])};
        const double size = std::hypot(direction[0], direction[1], direction[2]);
        Vec3 q;
        const Vec3 on_cube{cube, cube * p[1], cube * p[2]};
        const double r = shell == 0 ? outer : inner * std::pow(outer / inner, p[0]);
        for (int k = 0; k < 3; ++k)
          q[k] =
              shell == 0 ? (1 - p[0]) * on_cube[k] + p[0] * r * direction[k] / size : r * direction[k] / size;
        return turned(q, axis);
      });
    }
  }
  return join_meshes(parts, 1e-7 * radius.front());
}

std::vector<std::pair<int, double>> ball_potentials(const sim::space::Mesh& mesh, double outer,
                                                    const std::function<double(const Vec3&)>& potential) {
  std::vector<std::pair<int, double>> fixed;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const auto& p = mesh.nodes[n];
    if (std::fabs(p[2]) < 1e-9 * outer)
      fixed.emplace_back(static_cast<int>(n), 0.0);
    else if (std::hypot(p[0], p[1], p[2]) > outer * (1 - 1e-9))
      fixed.emplace_back(static_cast<int>(n), potential(p));
  }
  return fixed;
}

double ball_field(const sim::Steel& steel, double b0) {
  double low = 0, high = 3 * b0;
  for (int k = 0; k < 200; ++k) {
    const double b = 0.5 * (low + high);
    (b + 2 * mu0 * steel.h(b) > 3 * b0 ? high : low) = b;
  }
  return low;
}

ShellExact shell_exact(double mu, double a, double b) {
  const double thin = std::pow(a / b, 3);
  const double denominator = (2 * mu + 1) * (mu + 2) - 2 * thin * (mu - 1) * (mu - 1);
  return {9 * mu / denominator, (2 * mu + 1) * (mu - 1) * (b * b * b - a * a * a) / denominator};
}

sim::space::Problem solenoid(double radius, double length, double turns, int cells, sim::space::Cell cell) {
  const double half = 0.5 * length, far = 20 * std::max(radius, half);
  const double size = radius / (2 * cells);
  const auto z = sim::space::graded_line({{0, size}, {half, size}, {far, far / cells}}, 1.5, far / cells);
  auto outwards = sim::space::graded_line({{radius, size}, {far, far / cells}}, 1.5, far / cells);
  const auto line = even(cells);
  const double square = 0.5 * radius;
  std::vector<sim::space::Mesh> parts;
  const auto all_air = [](const Vec3&) { return 0; };
  parts.push_back(sim::space::grid_mesh(line, line, z, cell, all_air));
  sim::space::map_nodes(parts.back(), [&](const Vec3& p) {
    return Vec3{square * p[0], square * p[1], p[2]};
  });
  for (const bool outside : {false, true})
    for (const bool mirrored : {false, true}) {
      parts.push_back(mirrored
                          ? sim::space::grid_mesh(line, outside ? outwards : even(cells), z, cell, all_air)
                          : sim::space::grid_mesh(outside ? outwards : even(cells), line, z, cell, all_air));
      sim::space::map_nodes(parts.back(), [&](const Vec3& p) {
        const double out = p[mirrored ? 1 : 0], along = p[mirrored ? 0 : 1];
        const double angle = quarter * along;
        const double r = outside ? out : radius;
        double x = r * std::cos(angle), y = r * std::sin(angle);
        if (!outside) {
          x = (1 - out) * square + out * x;
          y = (1 - out) * square * along + out * y;
        }
        return mirrored ? Vec3{y, x, p[2]} : Vec3{x, y, p[2]};
      });
    }
  sim::space::Problem problem;
  problem.mesh = join_meshes(parts, 1e-6 * radius);
  problem.media = {sim::space::air()};
  problem.windings = {[=](const Vec3& p) -> Vec3 {
    return {0, 0, std::hypot(p[0], p[1]) < radius && p[2] < half ? turns / length : 0.0};
  }};
  problem.copies = 8;
  for (std::size_t n = 0; n < problem.mesh.nodes.size(); ++n)
    if (problem.mesh.nodes[n][2] == 0) problem.fixed.emplace_back(static_cast<int>(n), 0.0);
  return problem;
}

double solenoid_inductance(double radius, double length, double turns) {
  const double k2 = 4 * radius * radius / (4 * radius * radius + length * length);
  const double k = std::sqrt(k2), big_k = std::comp_ellint_1(k), big_e = std::comp_ellint_2(k);
  const double complementary = 1 - k2;
  const double nagaoka = 4 / (3 * std::numbers::pi * std::sqrt(complementary)) *
                         (complementary / k2 * (big_k - big_e) + big_e - k);
  return mu0 * turns * turns * std::numbers::pi * radius * radius / length * nagaoka;
}

}  // namespace powbench::bench
