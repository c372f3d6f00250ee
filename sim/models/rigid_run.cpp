#include "sim/models/rigid_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "sim/mechanics/stiff_solver.h"

namespace powbench::sim {
namespace {

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
  if (!(o.energy_bound >= 0)) refuse("energy_bound", o.energy_bound, "0 and above");
}

}  // namespace

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

namespace {

/// One closing under way.
class Closing {
 public:
  Closing(const RigidParts& parts, const CoilDrive& drive, const RigidOptions& options)
      : options_(options),
        contactor_(parts, drive, options.ledger),
        solver_(contactor_, options.tolerance, options.largest_step),
        stiff_(contactor_, options.tolerance),
        next_sample_(options.sample > 0 ? options.sample : 1e300),
        bound_(options.energy_bound > 0 ? options.energy_bound : std::max(1e-6, 100 * options.tolerance)) {
    contactor_.equilibrium(y_);
    contactor_.mark_energy(y_);
    contactor_.set_coil(0, y_, true);
    solver_.restart(0, y_, 1e-6);
  }

  RigidRun run() {
    run_.completed = true;
    while (solver_.end() < options_.end && run_.completed) {
      if (options_.stiff_fallback && solver_.stiff() && --patience_ < 0 && settle()) continue;
      const bool moved = solver_.extend();
      switch_off();
      sample();
      judge(moved);
    }
    run_.reached = std::min(solver_.end(), options_.end);
    run_.events = contactor_.events();
    std::erase_if(run_.events, [&](const RigidEvent& e) { return e.time > run_.reached; });
    run_.stages = closing_stages(run_.events, contactor_.bridges(), std::min(options_.off, run_.reached));
    run_.energies = contactor_.energies(solver_.end_state());
    run_.evaluations = solver_.evaluations() + stiff_.evaluations();
    run_.steps = solver_.steps() + run_.stiff_steps;
    return std::move(run_);
  }

 private:
  using Contactor = RigidContactor<double>;
  using Solver = EventSolver<Contactor>;

  void switch_off() {
    if (!on_ || solver_.end() < options_.off) return;
    solver_.state(options_.off, y_);  // what lies beyond is not used
    contactor_.set_coil(options_.off, y_, false);
    solver_.restart(options_.off, y_, 1e-6);
    on_ = false;
  }

  void sample() {
    while (next_sample_ <= std::min(solver_.end(), options_.end)) {
      solver_.state(next_sample_, y_);
      options_.each(next_sample_, contactor_, y_);
      next_sample_ = options_.sample * static_cast<double>(++samples_ + 1);
    }
  }

  /// The residual is a sum since t = 0: what a look misses, the next one sees.
  void judge(bool moved) {
    given_ += contactor_.friction_gain(solver_.end_state()) * (solver_.end() - solver_.begin());
    const bool drives = given_ > bound_ * contactor_.least_energy();
    const bool looks = ++judged_ % 8 == 0 || !moved || drives || solver_.end() >= options_.end;
    const double residual = options_.ledger && looks ? contactor_.energy_residual(solver_.end_state()) : 0.0;
    run_.energy_residual = std::max(run_.energy_residual, residual);
    if (moved && !drives && residual <= bound_) return;
    const char* why = !moved   ? "the step became too small"
                      : drives ? "friction gives energy"
                               : "the energy ledger does not close";
    run_.completed = false;
    run_.dump = describe(contactor_, solver_.end_state(), solver_.end(), residual, why);
  }

  /// Leaves a stiff settled phase to the fall-back, up to the next event, sample or switch. False: it gained nothing.
  bool settle() {
    constexpr double worth =
        20;  // a step of the fall-back costs about as much as so many of the explicit one
    const double least = worth * solver_.last_step();
    const double goal = std::min({options_.end, next_sample_, on_ ? options_.off : 1e300});
    double t = solver_.end();
    double h = 2 * least;
    std::copy_n(solver_.end_state(), Solver::capacity, y_);
    long taken = 0;
    while (t < goal && stiff_.step(t, y_, h, std::min(options_.largest_step, goal - t), least)) ++taken;
    patience_ = taken < 3 ? 200 : 0;
    if (taken == 0) return false;
    run_.stiff_steps += taken;
    solver_.restart(t, y_, least / worth);
    switch_off();
    sample();
    judge(true);
    return true;
  }

  RigidOptions options_;
  Contactor contactor_;
  Solver solver_;
  StiffSolver<Contactor> stiff_;
  RigidRun run_;
  alignas(64) double y_[Solver::capacity] = {};
  double next_sample_;
  double bound_;
  double given_ = 0;  ///< J, by friction
  long samples_ = 0;
  long judged_ = 0;
  int patience_ = 0;
  bool on_ = true;
};

}  // namespace

RigidRun run_rigid(const RigidParts& parts, const CoilDrive& drive, const RigidOptions& options) {
  check(options);
  return std::make_unique<Closing>(parts, drive, options)->run();
}

}  // namespace powbench::sim
