// Curved bodies: sphere on half-space, cylinder on block, Taylor's bar.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bench/solid/impact_cases.h"

namespace powbench::bench {
namespace {

using namespace sim;

/// 0 .. total, the first step `first`, each longer than the one before by `growth` (stretched to fit).
std::vector<double> graded(double total, double first, double growth) {
  std::vector<double> x{0};
  double step = first;
  while (x.back() < total) {
    x.push_back(x.back() + step);
    step *= growth;
  }
  const double fit = total / x.back();
  // the stretch grows from nothing at the fine end
  for (double& v : x) v *= 1 + (fit - 1) * v / x.back();
  x.back() = total;
  return x;
}

std::vector<double> mirrored(std::vector<double> x) {  // -total .. 0, fine at 0
  std::reverse(x.begin(), x.end());
  for (double& v : x) v = -v;
  return x;
}

void fix_symmetry(ExplicitSolid& s, const SolidMesh& mesh, double tolerance) {
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    s.fix(n, std::fabs(p.x) < tolerance, std::fabs(p.y) < tolerance, false);
  }
}

bool all_cells(int, int, int) {
  return true;
}

/// Quarter disc of radius 1 as quadrilaterals: a square core and two rings of n x n cells each.
struct Plane {
  std::vector<std::array<double, 2>> nodes;
  std::vector<std::array<int, 4>> cells;
};

Plane quarter_disc(int n) {
  Plane plane;
  std::map<std::pair<long, long>, int> known;
  const auto node = [&](double x, double y) {
    const auto key = std::make_pair(std::lround(x * 1e9), std::lround(y * 1e9));
    const auto [place, fresh] = known.try_emplace(key, static_cast<int>(plane.nodes.size()));
    if (fresh) plane.nodes.push_back({x, y});
    return place->second;
  };
  const auto block = [&](const auto& at) {
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        std::array<int, 4> c{};
        const int di[4] = {0, 1, 1, 0}, dj[4] = {0, 0, 1, 1};
        for (std::size_t k = 0; k < 4; ++k) {
          const auto p = at(static_cast<double>(i + di[k]) / n, static_cast<double>(j + dj[k]) / n);
          c[k] = node(p[0], p[1]);
        }
        plane.cells.push_back(c);
      }
  };
  constexpr double core = 0.5, bulge = 0.06;
  using Point = std::array<double, 2>;
  const auto inner = [&](double s, double t) {  // a square whose outer sides bulge a little
    return Point{core * s * (1 + bulge * (1 - t * t)), core * t * (1 + bulge * (1 - s * s))};
  };
  const auto ring = [&](double r, double t) {
    const Point from = inner(1, t);
    const double angle = t * std::atan(1.0);
    return Point{(1 - r) * from[0] + r * std::cos(angle), (1 - r) * from[1] + r * std::sin(angle)};
  };
  block(inner);
  block(ring);
  block([&](double s, double r) {
    const Point p = ring(r, s);
    return Point{p[1], p[0]};
  });
  return plane;
}

/// Of one part. Each face is cut from its lowest-numbered corner, so neighbours fit whatever the order of their
/// corners.
SolidMesh tetrahedra_around_middles(const SolidMesh& hexes) {
  static constexpr std::size_t faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                              {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  SolidMesh mesh;
  mesh.parts = hexes.parts;
  mesh.nodes = hexes.nodes;
  for (const SolidCell& hex : hexes.cells) {
    const int middle = static_cast<int>(mesh.nodes.size());
    Vec3 sum;
    for (const Vec3& p : corners_of(hexes, hex)) sum += p;
    mesh.nodes.push_back(0.125 * sum);
    for (const auto& face : faces) {
      std::array<int, 4> n{};
      for (std::size_t k = 0; k < 4; ++k) n[k] = hex.nodes[face[k]];
      std::rotate(n.begin(), std::min_element(n.begin(), n.end()), n.end());
      // seen from outside the corners turn anticlockwise: from the middle they turn clockwise
      for (const auto& t : {std::array<int, 3>{n[0], n[2], n[1]}, std::array<int, 3>{n[0], n[3], n[2]}})
        mesh.cells.push_back({{t[0], t[1], t[2], middle, -1, -1, -1, -1}, hex.part});
    }
  }
  return mesh;
}

}  // namespace

SphereImpact sphere_on_half_space(double finest, int workers) {
  SolidMesh mesh;
  const double radius = 10e-3, deep = 0.12;
  const int base = mesh.add_part("half-space");
  const auto side = graded(deep, finest, 1.25);
  add_grid(mesh, base, side, side, mirrored(side), all_cells);
  const int ball = mesh.add_part("sphere"), first = static_cast<int>(mesh.nodes.size());
  // the ball's face and the ball's mass, in columns: a whole ball of hexahedra has slivers that cost a hundredfold
  const double half = 0.65 * radius;
  const auto fine = graded(half, finest, 1.2), high = graded(1, finest / (2.5 * radius), 1.2);
  const auto face = [&](double x, double y) { return radius - std::sqrt(radius * radius - x * x - y * y); };
  double below = 0;
  constexpr int strips = 200;
  for (int i = 0; i < strips; ++i)
    for (int j = 0; j < strips; ++j)
      below += face((i + 0.5) * half / strips, (j + 0.5) * half / strips) / (strips * strips);
  const double top = below + std::acos(-1.0) / 3 * radius * radius * radius / (half * half);
  add_grid(mesh, ball, fine, fine, high, all_cells);
  map_nodes(mesh, first, [&](const Vec3& p) {
    const double bottom = face(p.x, p.y);
    return Vec3{p.x, p.y, bottom + p.z * (top - bottom)};
  });
  SolidOptions options;
  options.safety = 0.8;
  options.workers = workers;
  options.ledger_every = 500;
  ExplicitSolid s(mesh, {SolidMaterial{}, SolidMaterial{}}, options);
  fix_symmetry(s, mesh, 1e-9);
  for (int n = 0; n < first; ++n)
    if (mesh.nodes[static_cast<std::size_t>(n)].z < -deep + 1e-6) s.fix(n, true, true, true);
  s.set_velocity(ball, {0, 0, -1});
  ContactOptions contact;
  contact.pairs.push_back({base, ball});
  contact.pairs[0].factor = 2;  // the default has a compliance of a sixth of the approach in question
  contact.edges = false;
  s.set_contact(contact);
  SphereImpact r;
  double touch = -1, leave = 0;
  while (s.time() < 80e-6) {
    s.step();
    const double force = -4 * s.contact()->report(0).force.z;
    if (force > 0) {
      if (touch < 0) touch = s.time();
      leave = s.time();
    }
    r.force = std::max(r.force, force);
    if (s.steps() % 100 == 0) r.depth = std::max(r.depth, -s.mean_displacement(ball).z);
  }
  r.time = leave - touch;
  r.cells = static_cast<long>(mesh.cells.size());
  r.steps = s.steps();
  return r;
}

CylinderContact cylinder_on_block(double finest) {
  SolidMesh mesh;
  const double radius = 50e-3, thick = finest, wide = 100e-3, high = 100e-3;
  const int block = mesh.add_part("block");
  add_grid(mesh, block, graded(wide, finest, 1.12), {0, thick}, mirrored(graded(high, finest, 1.12)),
           all_cells);
  const int roll = mesh.add_part("cylinder"), first = static_cast<int>(mesh.nodes.size());
  const double reach = 0.97;
  add_grid(mesh, roll, graded(reach, finest / radius, 1.12), {0, thick}, graded(1, finest / radius, 1.12),
           all_cells);
  map_nodes(mesh, first, [&](const Vec3& p) {  // columns from the arc up to the middle plane
    const double fall = radius * std::sqrt(1 - p.x * p.x);
    return Vec3{radius * p.x, p.y, radius - fall * (1 - p.z)};
  });
  SolidMaterial aluminium, steel;
  aluminium.young = 7e10;
  aluminium.density = 2700;
  aluminium.damping = steel.damping = 2e4;
  SolidOptions options;
  options.ledger_every = 2000;
  options.energy_bound = 0.05;
  ExplicitSolid s(mesh, {aluminium, steel}, options);
  NodeShares top;
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
    s.fix(n, std::fabs(p.x) < 1e-12, true, n < first && p.z < -high + 1e-9);
    if (n >= first && p.z > radius - 1e-9) top.nodes.push_back(n);
  }
  double mass = 0;
  for (const int n : top.nodes) mass += s.cells().masses()[static_cast<std::size_t>(n)];
  for (const int n : top.nodes) top.shares.push_back(s.cells().masses()[static_cast<std::size_t>(n)] / mass);
  ContactOptions contact;
  contact.pairs.push_back({block, roll});
  contact.pairs[0].factor = 2;
  contact.edges = false;
  contact.pressures = true;
  s.set_contact(contact);
  const double full = 35e3 / 1e-3 * thick / 2, ramp = 1.5e-3, end = 3e-3;
  const int load = s.add_load({top, {0, 0, 0}});
  double pressed = 0, count = 0;
  std::vector<double> pressure(mesh.nodes.size(), 0.0);
  while (s.time() < end) {
    const double t = std::min(1.0, s.time() / ramp);
    s.set_force(load, {0, 0, -full * t * t * (3 - 2 * t)});
    s.step();
    if (s.time() < 0.8 * end || s.steps() % 50 != 0) continue;
    const auto now = s.contact()->node_pressure();
    for (std::size_t n = 0; n < pressure.size(); ++n) pressure[n] += now[n];
    pressed -= s.contact()->report(0).force.z;
    count += 1;
  }
  CylinderContact r;
  r.load = 2 * pressed / count / thick;
  // p^2 falls linearly with x^2 in Hertz's ellipse: a straight line through the inner 80 % gives p0 and a
  double sx = 0, sy = 0, sxx = 0, sxy = 0, m = 0;
  double peak = 0;
  for (const double p : pressure) peak = std::max(peak, p / count);
  for (int n = 0; n < first; ++n) {
    const double p = pressure[static_cast<std::size_t>(n)] / count;
    const Vec3& at = mesh.nodes[static_cast<std::size_t>(n)];
    if (p < 0.45 * peak || at.z < -1e-9) continue;
    const double x = at.x * at.x, y = p * p;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    m += 1;
  }
  const double slope = (m * sxy - sx * sy) / (m * sxx - sx * sx), top2 = (sy - slope * sx) / m;
  r.pressure = std::sqrt(top2);
  r.half_width = std::sqrt(-top2 / slope);
  return r;
}

SolidMesh taylor_mesh(int across, int along) {
  const double radius = 3.2e-3, length = 32.4e-3;
  const Plane plane = quarter_disc(across);
  SolidMesh mesh;
  const int part = mesh.add_part("rod"), layer = static_cast<int>(plane.nodes.size());
  for (int k = 0; k <= along; ++k)
    for (const auto& p : plane.nodes)
      mesh.nodes.push_back({radius * p[0], radius * p[1], length * k / along});
  for (int k = 0; k < along; ++k)
    for (const auto& c : plane.cells) {
      SolidCell cell;
      cell.part = part;
      const bool turned =
          (plane.nodes[static_cast<std::size_t>(c[1])][0] - plane.nodes[static_cast<std::size_t>(c[0])][0]) *
                  (plane.nodes[static_cast<std::size_t>(c[3])][1] -
                   plane.nodes[static_cast<std::size_t>(c[0])][1]) -
              (plane.nodes[static_cast<std::size_t>(c[1])][1] -
               plane.nodes[static_cast<std::size_t>(c[0])][1]) *
                  (plane.nodes[static_cast<std::size_t>(c[3])][0] -
                   plane.nodes[static_cast<std::size_t>(c[0])][0]) <
          0;
      for (std::size_t a = 0; a < 4; ++a) {
        const int n = c[turned ? 3 - a : a];
        cell.nodes[a] = k * layer + n;
        cell.nodes[4 + a] = (k + 1) * layer + n;
      }
      mesh.cells.push_back(cell);
    }
  return mesh;
}

TaylorBar taylor_bar(int across, int along, bool held, TaylorCells cells, double hourglass) {
  const SolidMesh hexes = taylor_mesh(across, along),
                  mesh = cells == TaylorCells::tetrahedra ? tetrahedra_around_middles(hexes) : hexes;
  SolidMaterial copper;
  copper.young = 110e9;
  copper.density = 8970;
  copper.yield = 400e6;
  copper.hardening = 100e6;
  copper.hourglass = hourglass;
  SolidOptions options;
  options.safety = 0.6;
  options.ledger_every = 100;
  options.energy_bound = 0.02;
  ExplicitSolid s(mesh, {copper}, options);
  fix_symmetry(s, mesh, 1e-12);
  s.set_velocity(0, {0, 0, -227});
  if (held) {
    for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
      const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
      s.fix(n, p.x < 1e-12, p.y < 1e-12, p.z < 1e-12);
      if (p.z < 1e-12) s.set_node_velocity(n, {0, 0, 0});
    }
  } else {
    s.add_plane(0, {0, 0, 0}, {0, 0, 1}, 0.65);
  }
  TaylorBar r;
  while (s.time() < 80e-6) {
    s.step();
    r.residual = std::max(r.residual, std::fabs(s.energies().residual()) / s.energies().start);
  }
  double low = 1e300, high = -1e300;
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    const Vec3 p = mesh.nodes[static_cast<std::size_t>(n)] + s.displacement(n);
    low = std::min(low, p.z);
    high = std::max(high, p.z);
    r.radius = std::max(r.radius, std::hypot(p.x, p.y));
  }
  r.length = high - low;
  for (const auto& c : s.cells().stresses(s.displacements()))
    r.plastic_strain = std::max(r.plastic_strain, c.plastic);
  r.steps = s.steps();
  return r;
}

}  // namespace powbench::bench
