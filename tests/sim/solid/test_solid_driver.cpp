#include <catch2/catch.hpp>
#include <iostream>

#include "tests/sim/solid/solid_cases.h"

using namespace powbench::sim;
using namespace powbench::sim::cases;

TEST_CASE("energy of an undamped vibration stays to round-off") {
  SolidMesh mesh;
  add_box(mesh, mesh.add_part("box"), {0, 0, 0}, {0.004, 0.004, 0.01}, 4, 4, 10);
  SolidMaterial m = material(2e11, 0.3, 7850);
  m.small_displacement = true;
  SolidOptions options;
  options.ledger_every = 500;
  ExplicitSolid s(mesh, {m}, options);
  for (int n = 0; n < static_cast<int>(mesh.nodes.size()); ++n)
    s.set_node_velocity(n, {std::sin(n), std::cos(2 * n), std::sin(3 * n)});
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    s.step();
    worst = std::max(worst, std::fabs(s.energies().residual()) / s.energies().start);
  }
  std::cout << "undamped vibration, 2e4 steps: energy residual " << worst << "\n";
  CHECK(worst < 1e-9);
}
