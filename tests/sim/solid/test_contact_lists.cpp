// Contact looks at few pairs of nodes and faces. Nothing may be missed by that: beside the same contact that looks at
// every pair in every step, and the vector code beside the plain one, to the bit.

#include <catch2/catch.hpp>
#include <iostream>

#include "core/random.h"
#include "sim/solid/contact_geometry.h"
#include "sim/solid/contact_kernel.h"
#include "tests/sim/solid/solid_cases.h"

using namespace powbench;
using namespace powbench::sim;
using namespace powbench::sim::cases;

namespace {

std::vector<const ContactKernel*> kernels() {
  std::vector<const ContactKernel*> all{&portable_contact_kernel()};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) all.push_back(&avx2_contact_kernel());
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    all.push_back(&avx512_contact_kernel());
#endif
  return all;
}

/// A block of small faces, or of faces larger than the table's, above a table; the block is carried along a path.
struct Carried {
  SolidMesh mesh;
  int first = 0;  ///< node of the block
  std::unique_ptr<CellBatches> cells;
  std::vector<double> inverse_mass, u, v;

  Carried(int block_cells, double tilt, bool tetrahedra) {
    const double h = 1e-3;
    add_box(mesh, mesh.add_part("table"), {-3 * h, -3 * h, -2 * h}, {3 * h, 3 * h, 0}, 6, 6, 2);
    first = add_box(mesh, mesh.add_part("block"), {-1.6 * h, -1.4 * h, 0}, {1.5 * h, 1.3 * h, 2 * h},
                    block_cells, block_cells, 2);
    map_nodes(mesh, first, [&](const Vec3& p) {
      return Vec3{p.x + tilt * p.z, p.y, p.z - tilt * p.x + 2 * h * std::fabs(tilt) + 1e-9};
    });
    if (tetrahedra) mesh = tetrahedra_of(mesh);
    cells = std::make_unique<CellBatches>(mesh, std::vector<SolidMaterial>(2), false);
    inverse_mass.assign(4 * mesh.nodes.size(), 1.0);
    u.assign(4 * mesh.nodes.size(), 0.0);
    v = u;
  }

  void carry(const Vec3& by, double dt) {
    for (auto n = static_cast<std::size_t>(first); n < mesh.nodes.size(); ++n)
      for (std::size_t i = 0; i < 3; ++i) {
        v[4 * n + i] = (by[i] - u[4 * n + i]) / dt;
        u[4 * n + i] = by[i];
      }
  }
};

ContactOptions rubbing(bool exhaustive) {
  ContactPair pair{0, 1};
  pair.friction_static = 0.3;
  pair.friction_dynamic = 0.2;
  pair.decay = 0.1;
  ContactOptions options;
  options.pairs.push_back(pair);
  options.exhaustive = exhaustive;
  return options;
}

struct Outcome {
  long steps = 0, touching = 0, searches = 0, differ = 0;
};

/// Both ways along one path; `path` gives the displacement of each step.
template <class Path>
Outcome both_ways(Carried body, int steps, Path path) {
  constexpr double dt = 1e-7;
  SolidContact few(*body.cells, body.inverse_mass, rubbing(false));
  SolidContact all(*body.cells, body.inverse_mass, rubbing(true));
  NodeForces few_forces(body.mesh.nodes.size()), all_forces(body.mesh.nodes.size()),
      damped(body.mesh.nodes.size());
  Outcome o;
  for (; o.steps < steps; ++o.steps) {
    body.carry(path(o.steps), dt);
    const NodeView view{&body.mesh.nodes, body.u.data(), body.v.data()};
    few_forces.clear();
    all_forces.clear();
    few.apply(view, dt, few_forces, damped);
    all.apply(view, dt, all_forces, damped);
    bool same = few.report(0).touching == all.report(0).touching && few.stored() == all.stored() &&
                few.friction_lost() == all.friction_lost();
    for (int n = 0; n < static_cast<int>(body.mesh.nodes.size()); ++n)
      same = same && few_forces[n] == all_forces[n];
    o.differ += !same;
    o.touching += few.report(0).touching > 0;
  }
  o.searches = few.searches();
  return o;
}

void report(const char* what, const Outcome& o) {
  std::cout << "contact lists, " << what << ": " << o.steps << " steps, " << o.touching << " in touch, "
            << o.searches << " searches, " << o.differ << " differ from all pairs\n";
}

}  // namespace

TEST_CASE("faces seen by every instruction set are those of the plain projection, to the bit") {
  Random random(5);
  constexpr int count = 400 * contact_lanes;
  std::vector<double> points, places;
  std::vector<int> point, corners, face;
  for (int k = 0; k < count; ++k) {
    const double warp = k % 3 == 0 ? 0 : 0.1;
    const Vec3 square[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (const Vec3& c : square)
      for (int i = 0; i < 4; ++i)
        places.push_back(i < 3 ? c[static_cast<std::size_t>(i)] + warp * (random.uniform() - 0.5) : 0);
    // above the face, beside it, above a border and a corner exactly
    for (int i = 0; i < 2; ++i)
      points.push_back(k % 5 == 0 ? std::floor(3 * random.uniform()) / 2 : 2 * random.uniform() - 0.5);
    points.push_back(k % 7 == 0 ? 0 : 0.4 * (random.uniform() - 0.5));
    points.push_back(0);
    point.push_back(4 * k);
    face.push_back(k);
    for (int c = 0; c < 4; ++c) corners.push_back(4 * (4 * k + c));
  }
  for (const ContactKernel* kernel : kernels()) {
    CAPTURE(kernel->name);
    std::vector<SeenFaces> seen(count / contact_lanes);
    kernel->see({points.data(), point.data(), places.data(), corners.data(), face.data(),
                 count / contact_lanes, 0.3, 1e-3, seen.data()});
    long differ = 0, beside = 0;
    for (std::size_t k = 0; k < count; ++k) {
      std::array<Vec3, 4> p{};
      for (std::size_t c = 0; c < 4; ++c)
        p[c] = {places[16 * k + 4 * c], places[16 * k + 4 * c + 1], places[16 * k + 4 * c + 2]};
      const Projection at = project(p, 4, {points[4 * k], points[4 * k + 1], points[4 * k + 2]});
      const SeenFaces& s = seen[k / contact_lanes];
      const std::size_t l = k % contact_lanes;
      bool same = s.distance[l] == at.distance && s.gap[l] == at.gap && s.aside[l] == at.aside;
      for (std::size_t i = 0; i < 3; ++i) same = same && s.normal[i][l] == at.normal[i];
      for (std::size_t c = 0; c < 4; ++c) same = same && s.weights[c][l] == at.weights[c];
      differ += !same;
      beside += at.aside > 0;
    }
    CHECK(differ == 0);
    CHECK(beside > count / 4);
  }
}

TEST_CASE("contact misses nothing of a body that strikes fast, again and again") {
  Outcome sum;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    // up to 0.4 of a face in one step, to and fro, into the table by a tenth of a face, and off beyond reach
    Vec3 at{0, 0, 0.004}, speed{0, 0, -4e-4};
    const auto path = [&](long) {
      at += speed;
      const bool in = at.z<-1e-4, out = at.z> 0.006;
      if (in || out) {
        const double fast = std::pow(10.0, -4 * random.uniform()) * 4e-4;
        speed = {(random.uniform() - 0.5) * 4e-4, (random.uniform() - 0.5) * 4e-4,
                 in ? fast + 2e-6 : -fast - 2e-6};
        if (std::fabs(at.x) > 2e-3) speed.x = -std::copysign(2e-4, at.x);
        if (std::fabs(at.y) > 2e-3) speed.y = -std::copysign(2e-4, at.y);
        at.z = in ? -1e-4 : 0.006;
      }
      return at;
    };
    const Outcome o = both_ways(Carried(1 + static_cast<int>(seed % 4), 0, seed == 6), 250, path);
    sum.steps += o.steps;
    sum.touching += o.touching;
    sum.searches += o.searches;
    sum.differ += o.differ;
  }
  report("fast", sum);
  CHECK(sum.differ == 0);
  CHECK(sum.touching > 20);
}

TEST_CASE("contact finds a body again that went a hundred faces away and returns, slow or fast") {
  for (const double fast : {4e-4, 1e-4}) {
    const long there = static_cast<long>(0.1 / fast);
    Outcome o = both_ways(Carried(3, 0, false), static_cast<int>(2 * there + 40), [&](long k) {
      const double way = fast * static_cast<double>(std::min(k, 2 * there - k));
      const double away = std::max(way, -1e-6) - 5e-5;  // ends as it starts: pressed in
      return Vec3{0.3 * away, 0, away};
    });
    report("a body that returns", o);
    CHECK(o.differ == 0);
    CHECK(o.touching > 20);
    CHECK(o.searches < o.steps / 10);
  }
}

TEST_CASE("the friction of a node that leaves its faces within one step is booked") {
  // slides for three steps, then is deeper than half of a face at once and keeps no candidate
  const Outcome o = both_ways(Carried(3, 0, false), 8, [](long k) {
    return Vec3{1e-7 * static_cast<double>(k), 0, k < 4 ? -4e-5 : -8.5e-4};
  });
  report("a node that leaves", o);
  CHECK(o.touching == 4);
  CHECK(o.differ == 0);
}

TEST_CASE("contact misses nothing of a grazing body, over the border of a table and from the side") {
  Outcome sum;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Random random(20 + seed);
    const double tilt = seed % 2 ? 0.02 * (random.uniform() - 0.5) : 0, step = 6e-6 + 4e-5 * random.uniform();
    const double height = 1e-6 * (random.uniform() - 0.7), along = random.uniform(),
                 sway = 3e-6 * random.uniform();
    // from beyond the border over the table and beyond the other one
    const Outcome o = both_ways(Carried(2 + static_cast<int>(seed % 3), tilt, seed == 8), 300, [&](long k) {
      const double x = -5e-3 + step * static_cast<double>(k);
      return Vec3{x, along * x, height + sway * std::sin(0.37 * static_cast<double>(k))};
    });
    sum.steps += o.steps;
    sum.touching += o.touching;
    sum.searches += o.searches;
    sum.differ += o.differ;
  }
  report("grazing", sum);
  CHECK(sum.differ == 0);
  CHECK(sum.touching > 100);
  CHECK(sum.searches < sum.steps / 5);
}

TEST_CASE("which faces a node has looked at before changes nothing where nodes stand on corners of faces") {
  // cells of the same size one above the other: every node touches four faces at once, presses in to a quarter of what
  // counts as near, and creeps over the corners to and fro
  Outcome sum;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Carried body(3, 0, seed == 6);
    map_nodes(body.mesh, body.first, [&](const Vec3& p) {
      const auto even = [](double x, double from, double to) {
        return 1e-3 * std::round(3 * (x - from) / (to - from));
      };
      const double bulge = seed % 2 ? 1e-6 * (p.x * p.x + 2 * p.y * p.y) / 1e-6 : 0;
      return Vec3{even(p.x, -1.6e-3, 1.5e-3), even(p.y, -1.4e-3, 1.3e-3), p.z + bulge};
    });
    body.cells = std::make_unique<CellBatches>(body.mesh, std::vector<SolidMaterial>(2), false);
    Random random(70 + seed);
    Vec3 at{};
    const Outcome o = both_ways(std::move(body), 300, [&](long k) {
      const double reach = std::pow(10.0, -9 + 4 * random.uniform());
      at.x = reach * (random.uniform() - 0.5);
      at.y = k % 3 == 0 ? 0 : reach * (random.uniform() - 0.5);
      at.z = -1.4e-4 * random.uniform();
      return at;
    });
    sum.steps += o.steps;
    sum.touching += o.touching;
    sum.searches += o.searches;
    sum.differ += o.differ;
  }
  report("corner on corner", sum);
  CHECK(sum.differ == 0);
  CHECK(sum.touching > 1700);
  CHECK(sum.searches < sum.steps / 20);
}

TEST_CASE("an impact with friction and plastic flow is the same with lists and with all pairs, to the bit") {
  int touched = 0;
  const auto impact = [&](bool exhaustive) {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("base"), {0, 0, 0}, {0.006, 0.006, 0.002}, 6, 6, 2);
    const int first =
        add_box(mesh, mesh.add_part("block"), {0.0017, 0.0016, 0.00203}, {0.0043, 0.0045, 0.005}, 3, 3, 3);
    map_nodes(mesh, first, [](const Vec3& p) {
      return Vec3{p.x + 0.1 * (p.z - 0.00203), p.y, p.z + 1e-2 * (p.x - 0.0017)};
    });
    SolidMaterial soft = material(1.2e11, 0.34, 8930);
    soft.yield = 2e8;
    soft.hardening = 1e9;
    SolidOptions options;
    options.ledger_every = 50;
    auto s =
        std::make_unique<ExplicitSolid>(mesh, std::vector<SolidMaterial>{SolidMaterial{}, soft}, options);
    s->set_velocity(1, {3, 1, -10});
    ContactOptions contact = rubbing(exhaustive);
    contact.pairs[0].damping = 0.1;
    contact.pairs[0].stick_damping = 0.1;
    s->set_contact(contact);
    for (int k = 0; k < 150; ++k) {
      s->step();
      touched += s->contact()->report(0).touching > 0;
    }
    return s;
  };
  const auto few = impact(false), all = impact(true);
  const SolidState a = few->save(), b = all->save();
  std::cout << "contact lists, impact: " << few->contact()->searches()
            << " searches in 150 steps, plastic work " << few->energies().plastic / few->energies().start
            << " of the energy\n";
  CHECK(touched > 50);
  CHECK(few->energies().plastic > 0);
  CHECK(few->energies().friction > 0);
  CHECK(few->contact()->searches() < 20);
  CHECK(a.u == b.u);
  CHECK(a.v == b.v);
  CHECK(a.contact == b.contact);
}
