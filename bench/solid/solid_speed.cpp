#include <cstdio>
#include <ctime>

#include "sim/solid/explicit_solid.h"

using namespace powbench::sim;

int main() {
  for (const bool in_float : {false, true}) {
    SolidMesh mesh;
    add_box(mesh, mesh.add_part("bar"), {0, 0, 0}, {0.016, 0.016, 0.02}, 16, 16, 20);
    SolidOptions o;
    o.float_forces = in_float;
    o.ledger_every = 0;
    ExplicitSolid s(mesh, {SolidMaterial{}}, o);
    s.set_velocity(0, {0, 0, -1});
    s.step();
    const auto t = std::clock();
    for (int k = 0; k < 1000; ++k) s.step();
    const double cpu = static_cast<double>(std::clock() - t) / CLOCKS_PER_SEC;
    std::printf("%s %s: %.1f M\n", best_cell_kernel().name, in_float ? "float" : "double",
                5120 * 1000 / cpu / 1e6);
  }
}
