#include "bench/solid/impact_cases.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace powbench::bench {
namespace {

using namespace sim;

SolidMaterial material(double young, double poisson, double density) {
  SolidMaterial m;
  m.young = young;
  m.poisson = poisson;
  m.density = density;
  return m;
}

}  // namespace

BarOnWall bar_on_wall(int cells, double safety, double factor) {
  SolidMesh mesh;
  const double length = 0.1, h = length / cells;
  add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {4 * h, 4 * h, length}, 4, 4, cells);
  const SolidMaterial m = material(2e11, 0, 7850);
  SolidOptions options;
  options.safety = safety;
  options.ledger_every = 4;
  options.energy_bound = 0.05;
  ExplicitSolid s(mesh, {m}, options);
  s.set_velocity(0, {0, 0, -1});
  s.add_plane(0, {0, 0, 0}, {0, 0, 1}, factor);
  const double expected = 2 * length / std::sqrt(m.young / m.density);
  double touch = -1, leave = 0, strain = 0;
  BarOnWall r{0, 1e300, 0, 0, 0};
  while (s.time() < 1.5 * expected) {
    s.step();
    if (s.plane_force() > 0) {
      if (touch < 0) touch = s.time() - s.dt();
      leave = s.time();
    }
    const SolidEnergies& e = s.energies();
    r.hourglass = std::max(r.hourglass, e.hourglass);
    strain = std::max(strain, e.strain);
    r.residual = std::max(r.residual, std::fabs(e.residual()) / e.start);
    if (s.time() < 1.1 * expected) continue;
    r.kinetic_low = std::min(r.kinetic_low, e.kinetic / e.start);
    r.kinetic_high = std::max(r.kinetic_high, e.kinetic / e.start);
  }
  r.contact_error = (leave - touch) / expected - 1;
  r.hourglass /= strain;
  return r;
}

ConfinedBar confined_bar(int cells) {
  SolidMesh mesh;
  const double length = 0.2, h = length / cells, gap = 2e-3;
  add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {h, h, length}, 1, 1, cells);
  SolidMaterial m = material(2e11, 0.3, 8000);
  m.small_displacement = true;  // the case is posed in small strains
  ExplicitSolid s(mesh, {m});
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) s.fix(n, true, true, false);
  s.set_velocity(0, {0, 0, -100});
  s.add_plane(0, {0, 0, -gap}, {0, 0, 1}, 1);
  ConfinedBar r;
  r.touch = -1;
  double sum = 0, count = 0, passed[2] = {-1, -1};
  const std::size_t probe[2] = {static_cast<std::size_t>(cells / 5), static_cast<std::size_t>(3 * cells / 5)};
  const double sigma = m.density * std::sqrt(m.wave_modulus() / m.density) * 100;
  while (s.time() < 1.1e-4) {
    s.step();
    if (s.plane_force() > 0) {
      if (r.touch < 0) r.touch = s.time() - s.dt();
      r.leave = s.time();
    }
    const auto stress = s.cells().stresses(s.displacements());
    if (s.time() > 40e-6 && s.time() < 68e-6) {
      sum -= stress[0].stress[2];
      count += 1;
    }
    for (int k = 0; k < 2; ++k)
      if (passed[k] < 0 && -stress[probe[k]].stress[2] > 0.5 * sigma) passed[k] = s.time();
  }
  r.plateau = sum / count;
  r.front = static_cast<double>(probe[1] - probe[0]) * h / (passed[1] - passed[0]);
  return r;
}

TwoBars two_bars(bool nodes_meet) {
  SolidMesh mesh;
  const double length = 0.1, side = 4e-3, v = 1;
  const int other = nodes_meet ? 4 : 3;
  add_box(mesh, mesh.add_part("struck"), {0, 0, 0}, {side, side, length}, 4, 4, 100);
  add_box(mesh, mesh.add_part("striking"), {0, 0, length}, {side, side, 2 * length}, other, other, 100);
  const SolidMaterial m = material(2e11, 0, 7850);
  SolidOptions options;
  options.ledger_every = 10;
  ExplicitSolid s(mesh, {m, m}, options);
  s.set_velocity(1, {0, 0, -v});
  ContactOptions contact;
  contact.pairs.push_back({0, 1});
  s.set_contact(contact);
  const double c = std::sqrt(m.young / m.density), expected = 2 * length / c;
  double touch = -1, leave = 0, sum = 0, count = 0;
  TwoBars r;
  while (s.time() < 1.4 * expected) {
    s.step();
    const ContactReport& now = s.contact()->report(0);
    if (now.touching > 0) {
      if (touch < 0) touch = s.time() - s.dt();
      leave = s.time();
    }
    if (s.time() > 0.3 * expected && s.time() < 0.7 * expected) {
      sum -= now.force.z;
      count += 1;
    }
    r.residual = std::max(r.residual, std::fabs(s.energies().residual()) / s.energies().start);
  }
  r.contact_error = (leave - touch) / expected - 1;
  r.v_first = -s.mean_velocity(1).z / v;
  r.v_second = -s.mean_velocity(0).z / v;
  r.force_error = sum / count / (0.5 * m.density * c * v * side * side) - 1;
  return r;
}

double cantilever_error(int through, double slenderness, double hourglass) {
  SolidMesh mesh;
  const double h = 1e-3, length = slenderness * h;
  const int along = static_cast<int>(slenderness * through / 2);  // cells twice as long as high
  add_box(mesh, mesh.add_part("beam"), {0, 0, 0}, {length, h, h}, along, 2, through);
  SolidMaterial m = material(2.1e11, 0.3, 7850);
  m.hourglass = hourglass;
  SolidOptions options;
  options.ledger_every = 0;
  ExplicitSolid s(mesh, {m}, options);
  // started in the first mode's velocity, so that the tip swings with one frequency
  constexpr double beta = 1.87510407;
  const double ratio = (std::cosh(beta) + std::cos(beta)) / (std::sinh(beta) + std::sin(beta));
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n) {
    const double x = beta * mesh.nodes[static_cast<std::size_t>(n)].x / length;
    s.set_node_velocity(n,
                        {0, 0, 1e-3 * (std::cosh(x) - std::cos(x) - ratio * (std::sinh(x) - std::sin(x)))});
    if (x == 0) s.fix(n, true, true, true);
  }
  const double expected = beta * beta * std::sqrt(m.young * h * h / (12 * m.density)) / (length * length);
  const int tip = along;
  double before = 0, first = -1, last = -1;
  int crossings = 0;
  while (crossings < 5) {  // zero crossings of the tip, downwards and upwards
    s.step();
    const double now = s.displacement(tip).z;
    if (s.steps() > 10 && (now > 0) != (before > 0)) {
      const double t = s.time() - s.dt() * now / (now - before);
      if (first < 0) first = t;
      last = t;
      ++crossings;
    }
    before = now;
  }
  return 4 * pi / (last - first) / expected - 1;
}

}  // namespace powbench::bench
