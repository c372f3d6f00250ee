#include "bench/mechanics/rigid_runs.h"

#include <algorithm>
#include <ctime>
#include <memory>

#include "bench/mechanics/reference_closing.h"

namespace powbench::bench {
namespace {

template <class Real>
ClosingRun run(const sim::RigidParts& parts, Real tolerance, int repeats) {
  using Contactor = sim::RigidContactor<Real>;
  using Solver = sim::EventSolver<Contactor>;
  ClosingRun result;
  result.tolerance = static_cast<double>(tolerance);
  result.cpu_ms = 1e300;
  Contactor start(parts);
  alignas(64) Real y[Solver::capacity] = {};
  start.equilibrium(y);
  for (int i = 0; i < repeats; ++i) {
    Contactor contactor = start;
    contactor.events().reserve(4096);
    const double begin = cpu_ms();
    Solver solver(contactor, tolerance, Real(1e-3L));
    solver.restart(0, y, Real(1e-6L));
    while (solver.end() < Real(closing_end) && result.finished) result.finished = solver.extend();
    result.cpu_ms = std::min(result.cpu_ms, cpu_ms() - begin);
    result.steps = static_cast<long>(solver.steps());
    result.evaluations = static_cast<long>(solver.evaluations());
    result.events = contactor.events();
  }
  return result;
}

}  // namespace

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

ClosingRun own_run(const sim::RigidParts& parts, double tolerance, int repeats) {
  auto r = run<double>(parts, tolerance, repeats);
  r.method = "own 8(5,3), events";
  return r;
}

UndampedRun undamped_run(double tolerance, long steps) {
  using Contactor = sim::RigidContactor<double>;
  using Solver = sim::EventSolver<Contactor>;
  Contactor c(bench::without_losses(bench::reference_closing()), {}, true);
  alignas(64) double y[Solver::capacity] = {};
  c.equilibrium(y);
  c.mark_energy(y);
  const auto solver = std::make_unique<Solver>(c, tolerance, 1e-3);
  solver->restart(0, y, 1e-6);
  UndampedRun run;
  while (solver->steps() < steps && solver->extend()) {
    run.residual = std::max(run.residual, c.energy_residual(solver->end_state()));
    c.events().clear();
  }
  run.seconds = solver->end();
  run.events = static_cast<long>(solver->events());
  return run;
}

ClosingRun exact_run(const sim::RigidParts& parts, long double tolerance) {
  auto r = run<long double>(parts, tolerance, 1);
  r.method = "reference, long double";
  return r;
}

}  // namespace powbench::bench
