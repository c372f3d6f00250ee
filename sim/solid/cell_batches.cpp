#include "sim/solid/cell_batches.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace powbench::sim {
namespace {

constexpr std::size_t batch_cells = 512;
constexpr std::size_t lanes = block_cells;

/// Of the modes eta zeta, zeta xi, xi eta, the one that varies along neither of the others' axis: mode h bends the
/// directions other than h.
bool bends(std::size_t mode, std::size_t direction) {
  return mode != direction;
}

/// Axis (0 x, 1 y, 2 z) that each of xi, eta, zeta is closest to; false where two share one.
bool aligned(const HexShape& s, std::array<std::size_t, 3>& axis) {
  std::array<bool, 3> taken{};
  for (std::size_t m = 0; m < 3; ++m) {
    const Vec3& b = s.beta[m];
    axis[m] = std::fabs(b.x) >= std::fabs(b.y) && std::fabs(b.x) >= std::fabs(b.z) ? 0u
              : std::fabs(b.y) >= std::fabs(b.z)                                   ? 1u
                                                                                   : 2u;
    if (taken[axis[m]]) return false;
    taken[axis[m]] = true;
  }
  return true;
}

}  // namespace

std::array<double, 12> hourglass_stiffness(const HexShape& s, const SolidMaterial& m) {
  std::array<double, 3> g{};  // V b^2 summed over modes, by direction
  for (const Vec3& b : s.beta)
    for (int i = 0; i < 3; ++i) g[static_cast<std::size_t>(i)] += b[i] * b[i] / s.volume;
  const double e = m.young * m.hourglass, mu = m.mu() * m.hourglass;
  std::array<double, 12> k{};
  std::array<std::size_t, 3> axis{};
  const bool straight = aligned(s, axis);
  for (std::size_t h = 0; h < 4; ++h)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
      double& value = k[3 * h + i];
      if (!straight)
        value = e * (g[0] + g[1] + g[2]) / 9;
      else if (h == 3)
        value = (e * g[i] + mu * (g[j] + g[l])) / 9;
      else if (bends(axis[h], i))
        value = e * g[i] / 3;
      else
        value = mu * (g[j] + g[l]) / 3;
    }
  return k;
}

CellBatches::CellBatches(const SolidMesh& mesh, const std::vector<SolidMaterial>& materials,
                         bool float_forces)
    : mesh_(mesh), materials_(materials), in_float_(float_forces), kernel_(&best_cell_kernel()) {
  if (materials.size() != mesh.parts.size())
    throw std::invalid_argument("materials: " + std::to_string(materials.size()) + " given, the mesh has " +
                                std::to_string(mesh.parts.size()) + " parts");
  for (const auto& m : materials_) check_material(m);
  check_mesh(mesh_);
  for (std::size_t e = 0; e < mesh_.cells.size(); ++e) {
    const bool flows = material(mesh_.cells[e].part).law() == SolidLaw::plastic;
    if (in_float_ && (flows || !mesh_.cells[e].is_hex()))
      throw std::invalid_argument("mesh cell " + std::to_string(e) +
                                  ": forces in float are for elastic hexahedra");
  }
  sort_parts();
  cut();
  make_slots();
  add_masses();
}

void CellBatches::sort_parts() {
  std::vector<int> part(mesh_.nodes.size(), -1);
  for (const auto& cell : mesh_.cells)
    for (std::size_t a = 0; a < static_cast<std::size_t>(cell.corners()); ++a) {
      int& p = part[static_cast<std::size_t>(cell.nodes[a])];
      if (p >= 0 && p != cell.part)
        throw std::invalid_argument("mesh node " + std::to_string(cell.nodes[a]) +
                                    ": belongs to two parts; parts share no node");
      p = cell.part;
    }
  part_begin_.assign(mesh_.parts.size() + 1, 0);
  for (std::size_t n = 0; n < part.size(); ++n) {
    if (part[n] < 0) throw std::invalid_argument("mesh node " + std::to_string(n) + ": belongs to no cell");
    if (n > 0 && part[n] < part[n - 1])
      throw std::invalid_argument("mesh node " + std::to_string(n) +
                                  ": nodes must be in the order of their parts");
    ++part_begin_[static_cast<std::size_t>(part[n]) + 1];
  }
  for (std::size_t p = 0; p < mesh_.parts.size(); ++p) part_begin_[p + 1] += part_begin_[p];
}

CellBatches::Kind CellBatches::kind_of(const SolidCell& cell) const {
  const bool flows = material(cell.part).law() == SolidLaw::plastic;
  if (!cell.is_hex()) return flows ? Kind::plastic_tet : Kind::tet;
  if (flows) return Kind::plastic;
  std::array<Vec3, 8> x;
  double size = 0;
  for (std::size_t a = 0; a < 8; ++a) x[a] = mesh_.nodes[static_cast<std::size_t>(cell.nodes[a])];
  for (std::size_t a = 1; a < 8; ++a) size = std::max(size, norm(x[a] - x[0]));
  const HexShape s = hex_shape(x);
  for (const Vec3& h : s.hourglass)
    if (norm(h) > 1e-13 * (size + norm(x[0]))) return Kind::hex;
  return Kind::brick;
}

void CellBatches::cut() {
  std::map<std::pair<int, Kind>, std::vector<int>> groups;  // in a fixed order
  for (std::size_t e = 0; e < mesh_.cells.size(); ++e)
    groups[{mesh_.cells[e].part, kind_of(mesh_.cells[e])}].push_back(static_cast<int>(e));
  for (const auto& [key, cells] : groups)
    for (std::size_t from = 0; from < cells.size(); from += batch_cells) {
      Batch b;
      b.part = key.first;
      b.kind = key.second;
      const auto begin = cells.begin() + static_cast<std::ptrdiff_t>(from);
      b.cells.assign(begin, begin + static_cast<std::ptrdiff_t>(std::min(batch_cells, cells.size() - from)));
      fill(b);
      batches_.push_back(std::move(b));
    }
}

void CellBatches::number_nodes(Batch& b) {
  for (const int e : b.cells) {
    const auto& cell = mesh_.cells[static_cast<std::size_t>(e)];
    b.nodes.insert(b.nodes.end(), cell.nodes.begin(), cell.nodes.begin() + cell.corners());
  }
  std::sort(b.nodes.begin(), b.nodes.end());
  b.nodes.erase(std::unique(b.nodes.begin(), b.nodes.end()), b.nodes.end());
  b.spare = static_cast<int>(b.nodes.size());
}

std::size_t CellBatches::numbers_of(Kind k) {
  switch (k) {
    case Kind::brick:
      return brick_numbers;
    case Kind::hex:
      return hex_numbers;
    case Kind::tet:
      return tet_numbers;
    case Kind::plastic:
      return plastic_numbers;
    case Kind::plastic_tet:
      return plastic_tet_numbers;
  }
  return 0;
}

void CellBatches::fill(Batch& b) {
  number_nodes(b);
  const std::size_t corners = corners_of(b.kind), blocks = (b.cells.size() + lanes - 1) / lanes;
  b.corners.assign(blocks * corners * lanes, 4 * b.spare);
  for (std::size_t k = 0; k < b.cells.size(); ++k) {
    const auto& cell = mesh_.cells[static_cast<std::size_t>(b.cells[k])];
    for (std::size_t a = 0; a < corners; ++a) {
      const auto local = std::lower_bound(b.nodes.begin(), b.nodes.end(), cell.nodes[a]) - b.nodes.begin();
      b.corners[(k / lanes * corners + a) * lanes + k % lanes] = 4 * static_cast<int>(local);
    }
  }
  (flows(b.kind) ? b.state : b.shape).assign(blocks * numbers_of(b.kind) * lanes, 0.0);
  if (!flows(b.kind))
    for (std::size_t k = 0; k < b.cells.size(); ++k) fill_shape(b, k);
  if (!in_float_) return;
  for (const double s : b.shape) b.float_shape.push_back(static_cast<float>(s));
}

void CellBatches::fill_shape(Batch& b, std::size_t k) {
  const auto& cell = mesh_.cells[static_cast<std::size_t>(b.cells[k])];
  const auto corner = [&](std::size_t a) { return mesh_.nodes[static_cast<std::size_t>(cell.nodes[a])]; };
  const std::size_t numbers = numbers_of(b.kind);
  std::size_t next = 0;
  const auto put = [&](double value) { b.shape[(k / lanes * numbers + next++) * lanes + k % lanes] = value; };
  const auto put3 = [&](const Vec3& v) {
    put(v.x);
    put(v.y);
    put(v.z);
  };
  if (b.kind == Kind::tet) {
    const Vec3 d1 = corner(1) - corner(0), d2 = corner(2) - corner(0), d3 = corner(3) - corner(0);
    const double six = dot(d1, cross(d2, d3));
    put3(1 / six * cross(d2, d3));
    put3(1 / six * cross(d3, d1));
    put3(1 / six * cross(d1, d2));
    put(six / 6);
    return;
  }
  std::array<Vec3, 8> x;
  for (std::size_t a = 0; a < 8; ++a) x[a] = corner(a) - corner(0);
  const HexShape s = hex_shape(x);
  for (std::size_t m = 0; m < (b.kind == Kind::brick ? 3u : 6u); ++m) put3(1 / s.volume * s.beta[m]);
  put(s.volume);
  for (const double stiffness : hourglass_stiffness(s, material(cell.part))) put(stiffness);
  if (b.kind == Kind::hex)
    for (const Vec3& h : s.hourglass) put3(h);
}

void CellBatches::make_slots() {
  std::size_t place = 0;
  slot_begin_.assign(mesh_.nodes.size() + 1, 0);
  for (auto& b : batches_) {
    b.force_place = place;
    place += 4 * (b.nodes.size() + 1);
    for (const int n : b.nodes) ++slot_begin_[static_cast<std::size_t>(n) + 1];
  }
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) slot_begin_[n + 1] += slot_begin_[n];
  slots_.resize(static_cast<std::size_t>(slot_begin_.back()));
  std::vector<int> next(slot_begin_.begin(), slot_begin_.end() - 1);
  for (const auto& b : batches_)
    for (std::size_t k = 0; k < b.nodes.size(); ++k)
      slots_[static_cast<std::size_t>(next[static_cast<std::size_t>(b.nodes[k])]++)] =
          static_cast<int>(b.force_place + 4 * k);
  (in_float_ ? float_forces_.resize(place) : forces_.resize(place));
}

void CellBatches::add_masses() {
  masses_.assign(mesh_.nodes.size(), 0.0);
  for (const auto& cell : mesh_.cells) {
    const double share = material(cell.part).density * cell_volume(mesh_, cell) / cell.corners();
    for (std::size_t a = 0; a < static_cast<std::size_t>(cell.corners()); ++a)
      masses_[static_cast<std::size_t>(cell.nodes[a])] += share;
  }
}

Vec3 CellBatches::node_force(int node) const {
  Vec3 f;
  const auto n = static_cast<std::size_t>(node);
  for (int k = slot_begin_[n]; k < slot_begin_[n + 1]; ++k) {
    const auto place = static_cast<std::size_t>(slots_[static_cast<std::size_t>(k)]);
    for (int i = 0; i < 3; ++i) {
      const auto at = place + static_cast<std::size_t>(i);
      f[i] += in_float_ ? static_cast<double>(float_forces_[at]) : forces_[at];
    }
  }
  return f;
}

}  // namespace powbench::sim
