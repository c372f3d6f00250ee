#include <cstdio>
#include <cstdlib>
#include <ctime>
#include "bench/field3d/team20.h"
#include "sim/field3d/force3.h"
#include "sim/field3d/newton3.h"
using namespace powbench;
static double cpu() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}
int main(int argc, char** argv) {
  double size = argc > 1 ? atof(argv[1]) : 1;
  double t0 = cpu();
  auto t = bench::team20(size);
  sim::Coenergy3 w(t.problem);
  double t1 = cpu();
  sim::Newton3 newton(w);
  printf("cells %d nodes %zu unknowns %d nnz %zu setup %.2f analyse %.2f\n", t.problem.mesh.count(),
         t.problem.mesh.nodes.size(), w.unknowns(), w.hessian().uu.row.size(), t1 - t0, cpu() - t1);
  for (auto& r : bench::team20_measured) {
    double a = cpu();
    auto s = newton.solve({{false, r.ampere_turns}});
    double b = cpu();
    auto f = sim::stress_force(w, s.state, t.virtual_work), g = sim::stress_force(w, s.state, t.thin);
    printf(
        "NI %5.0f F %.3f (%+.2f %%) thin %.3f meas %.1f its %d line %d dec %.1e conv %d psi %.5g cpu %.2f\n",
        r.ampere_turns, f[2], 100 * (f[2] / r.pull - 1), g[2], r.pull, s.iterations, s.line_steps,
        s.decrement, s.converged, s.flux[0], b - a);
  }
}
