#include "sim/mechanics/rigid_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace powbench::sim {
namespace {

constexpr std::array<std::string_view, 6> stage_names = {"energising", "travel",  "touching",
                                                         "overtravel", "seating", "closed"};

std::string describe(const RigidContactor<double>& c, const double* y, double t, double residual,
                     const char* why) {
  char text[256];
  const auto e = c.energies(y);
  std::snprintf(text, sizeof text,
                "rigid: stopped at t = %.9g s, %s, energy residual %.3g\n"
                "J: kinetic %.6g springs %.6g contacts %.6g magnetic %.6g supplied %.6g lost %.6g\n",
                t, why, residual, e.kinetic, e.springs, e.contacts, e.magnetic, e.supplied, e.lost());
  std::string all = text;
  for (int i = 0; i < c.size(); ++i) {
    std::snprintf(text, sizeof text, "y[%d] = %.17g\n", i, y[i]);
    all += text;
  }
  for (int k = 0; k < rigid_contacts; ++k) {
    if (!c.uses(k)) continue;
    std::snprintf(text, sizeof text, "contact %d: depth %.9g m, %s\n", k, c.depth_of(k, y),
                  c.is_pressing(k) ? "pressing" : "free");
    all += text;
  }
  return all;
}

void check(const RigidOptions& o) {
  const auto refuse = [](const char* key, double value, const char* range) {
    char text[128];
    std::snprintf(text, sizeof text, "rigid: %s = %.6g, allowed %s", key, value, range);
    throw std::invalid_argument(text);
  };
  if (!(o.tolerance >= 1e-13 && o.tolerance <= 1e-3)) refuse("tolerance", o.tolerance, "1e-13 .. 1e-3");
  if (!(o.end > 0 && o.end <= 100)) refuse("end", o.end, "above 0 .. 100 s");
  if (!(o.largest_step > 1e-9 && o.largest_step <= 1e-2))
    refuse("largest_step", o.largest_step, "above 1e-9 .. 0.01 s");
  if (!(o.energy_bound > 0)) refuse("energy_bound", o.energy_bound, "above 0");
}

}  // namespace

std::string_view stage_name(ClosingStage s) {
  return stage_names[static_cast<std::size_t>(s)];
}

std::vector<StageTime> closing_stages(std::span<const RigidEvent> events, int bridges, double end,
                                      double calm) {
  double moves = -1, touches = -1, all = -1, seats = -1, last = 0;
  std::uint64_t touched = 0;
  int ends = 0;
  for (const auto& e : events) {
    if (e.time > end) continue;
    const auto place = contact_place(e.contact);
    if (place.kind == ContactKind::stop && !e.closes && touches < 0) moves = e.time;
    if (place.kind == ContactKind::pad || place.kind == ContactKind::pole) last = e.time;
    if (place.kind == ContactKind::pole && e.closes && seats < 0) seats = e.time;
    if (place.kind != ContactKind::pad || !e.closes) continue;
    if (touches < 0) touches = e.time;
    const std::uint64_t bit = std::uint64_t{1} << e.contact;
    if ((touched & bit) == 0 && ++ends == 2 * bridges) all = e.time;
    touched |= bit;
  }
  std::vector<StageTime> stages = {{ClosingStage::energising, 0}};
  const auto add = [&](ClosingStage s, double t) {
    if (t >= 0) stages.push_back({s, t});
  };
  add(ClosingStage::travel, moves);
  add(ClosingStage::touching, touches);
  if (seats < 0 || all < seats) add(ClosingStage::overtravel, all);  // a core that seats early has none
  add(ClosingStage::seating, seats);
  if (seats >= 0 && all >= 0 && last + calm < end) add(ClosingStage::closed, last);
  return stages;
}

RigidRun run_rigid(const RigidParts& parts, const CoilDrive& drive, const RigidOptions& options) {
  using Contactor = RigidContactor<double>;
  using Solver = EventSolver<Contactor>;
  check(options);
  Contactor contactor(parts, drive, options.ledger);
  alignas(64) double y[Solver::capacity] = {};
  contactor.equilibrium(y);
  contactor.mark_energy(y);
  contactor.set_coil(0, y, true);
  Solver solver(contactor, options.tolerance, options.largest_step);
  solver.restart(0, y, 1e-6);
  RigidRun run;
  run.completed = true;
  double next_sample = options.sample > 0 ? options.sample : 1e300;
  long samples = 0;
  bool on = true;
  alignas(64) double at[Solver::capacity] = {};
  while (solver.end() < options.end) {
    const bool moved = solver.extend();
    if (on && solver.end() >= options.off) {  // what lies beyond is not used
      solver.state(options.off, at);
      contactor.set_coil(options.off, at, false);
      solver.restart(options.off, at, 1e-6);
      on = false;
    }
    while (next_sample <= std::min(solver.end(), options.end)) {
      solver.state(next_sample, at);
      options.each(next_sample, contactor, at);
      next_sample = options.sample * static_cast<double>(++samples + 1);
    }
    const double residual = options.ledger ? contactor.energy_residual(solver.end_state()) : 0.0;
    run.energy_residual = std::max(run.energy_residual, residual);
    const char* why = !moved ? "the step became too small" : "the energy ledger does not close";
    if (moved && residual <= options.energy_bound) continue;
    run.completed = false;
    run.dump = describe(contactor, solver.end_state(), solver.end(), residual, why);
    break;
  }
  run.reached = std::min(solver.end(), options.end);
  run.events = contactor.events();
  std::erase_if(run.events, [&](const RigidEvent& e) { return e.time > run.reached; });
  run.stages = closing_stages(run.events, contactor.bridges(), run.reached);
  run.energies = contactor.energies(solver.end_state());
  run.evaluations = solver.evaluations();
  run.steps = solver.steps();
  return run;
}

}  // namespace powbench::sim
