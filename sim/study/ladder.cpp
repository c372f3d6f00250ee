#include "sim/study/ladder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace powbench::sim {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-12;  // s

void check(std::span<const Rung> rungs, const LadderOptions& o) {
  if (rungs.empty()) throw std::invalid_argument("rungs: at least one");
  if (o.tolerances.empty()) throw std::invalid_argument("tolerances: at least one");
  for (std::size_t k = 1; k < o.tolerances.size(); ++k)
    if (std::fabs(o.tolerances[k] / o.tolerances[k - 1] - 0.1) > 1e-6)
      throw std::invalid_argument("tolerances: allowed a list in which each is a tenth of the one before");
  if (!(o.truth < o.tolerances.back() / 10 * (1 - 1e-6)))
    throw std::invalid_argument("truth: allowed below a tenth of the finest tolerance");
}

struct RungRows {
  std::vector<LadderRow> rows;
  LadderRun truth;
};

/// Cells that are run when they are asked for.
LadderCell running(std::span<const Rung> rungs, const Case& c, double duration, const CpuClock& clock) {
  return [=, &clock](std::size_t rung, double setting, int repeats) {
    return run_rung(rungs, rung, c, duration, setting, clock, repeats);
  };
}

/// One rung at all tolerances, and one finer for the last estimate. Nothing where a cell is missing.
std::optional<RungRows> rows_of(std::span<const Rung> rungs, std::size_t rung, const LadderOptions& o,
                                const LadderCell& cell) {
  RungRows result;
  const auto& own = rungs[rung].settings;
  const int repeats = rungs[rung].costly ? 1 : o.repeats;
  const auto truth = cell(rung, own.empty() ? o.truth : own.back(), 1);
  const std::vector<double> settings =
      own.empty() ? o.tolerances : std::vector<double>(own.begin(), own.end() - 1);
  for (const double setting : settings)
    if (const auto run = cell(rung, setting, repeats)) result.rows.push_back({*run, {}, {}, false});
  const auto finest = own.empty() ? cell(rung, o.tolerances.back() / 10, 1) : truth;
  if (!truth || !finest || result.rows.size() != settings.size()) return std::nullopt;
  result.truth = *truth;
  const LadderRun& last = *finest;
  for (std::size_t k = 0; k < result.rows.size(); ++k) {
    auto& row = result.rows[k];
    row.estimate = error_estimate(row.run, k + 1 < result.rows.size() ? result.rows[k + 1].run : last);
    row.error = time_error(row.run, result.truth);
    row.same_train = row.run.openings == result.truth.openings;
  }
  return result;
}

double relative_to_touch(const LadderTimes& estimate, const LadderRun& run, double duration) {
  return largest(estimate) / (std::isnan(run.times[0]) ? duration : run.times[0]);
}

}  // namespace

std::vector<double> settings_of(const Rung& rung, double coarsest, double finest) {
  if (!rung.settings.empty()) return rung.settings;
  std::vector<double> list;
  for (double t = coarsest; t > 0.1 * finest * (1 + 1e-6); t /= 10) list.push_back(t);
  return list;
}

double largest(const LadderTimes& errors) {
  double worst = 0;
  for (const double e : errors)
    if (!std::isnan(e)) worst = std::max(worst, e);
  return worst;
}

LadderRun run_rung(std::span<const Rung> rungs, std::size_t rung, const Case& c, double duration,
                   double tolerance, const CpuClock& clock, int repeats) {
  LadderRun run;
  run.rung = rung;
  run.tolerance = tolerance;
  run.cpu = infinite;
  for (int k = 0; k < std::max(1, repeats); ++k) {
    const double start = clock();
    const auto r = rungs[rung].run(c, duration, tolerance, 0);
    run.cpu = std::min(run.cpu, clock() - start);
    const bool settles = !chatters(r.truth, std::min(c.conditions.hold_time, duration));
    run.times = {r.truth.touch.value_or(nan), r.truth.core_seat.value_or(nan),
                 settles ? r.truth.settled.value_or(nan) : nan};
    run.openings = r.truth.openings.size();
    run.evaluations = r.evaluations;
  }
  return run;
}

LadderTimes time_error(const LadderRun& a, const LadderRun& b) {
  LadderTimes result{};
  for (std::size_t q = 0; q < result.size(); ++q) {
    const bool one = std::isnan(a.times[q]) != std::isnan(b.times[q]);
    result[q] = one ? infinite : std::fabs(a.times[q] - b.times[q]);
  }
  return result;
}

LadderTimes error_estimate(const LadderRun& run, const LadderRun& finer) {
  LadderTimes result = time_error(run, finer);
  for (double& e : result)
    if (!std::isnan(e)) e = std::max(estimator_factor * e, rounding);
  return result;
}

LadderTimes model_difference(const LadderRun& run, const LadderRun& other,
                             const LadderTimes& step_error_of_other) {
  LadderTimes result = time_error(run, other);
  for (std::size_t q = 0; q < result.size(); ++q) result[q] += step_error_of_other[q];
  return result;
}

Ladder run_ladder(std::span<const Rung> rungs, const Case& c, const LadderOptions& o, const CpuClock& clock) {
  return *run_ladder(rungs, o, running(rungs, c, o.duration, clock));
}

std::optional<Ladder> run_ladder(std::span<const Rung> rungs, const LadderOptions& o,
                                 const LadderCell& cell) {
  check(rungs, o);
  Ladder ladder;
  bool whole = true;
  std::vector<LadderRun> truths;
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    const auto rows = rows_of(rungs, r, o, cell);
    whole = whole && rows;
    if (!whole) continue;  // the cells of the others are still looked at
    const RungRows& part = *rows;
    ladder.rows.insert(ladder.rows.end(), part.rows.begin(), part.rows.end());
    for (std::size_t other = 0; other < r; ++other)
      ladder.models.push_back({r, other, time_error(part.truth, truths[other])});
    truths.push_back(part.truth);
  }
  if (!whole) return std::nullopt;
  return ladder;
}

RungChoice choose_rung(std::span<const Rung> rungs, const Case& c, double accuracy, double duration,
                       const CpuClock& clock, double coarsest, double finest) {
  if (rungs.empty()) throw std::invalid_argument("rungs: at least one");
  if (!(accuracy >= 1e-10 && accuracy <= 0.5)) throw std::invalid_argument("accuracy: allowed 1e-10 .. 0.5");
  RungChoice best;
  best.relative = infinite;
  for (std::size_t r = 0; r < rungs.size(); ++r) {
    const auto settings = settings_of(rungs[r], coarsest, finest);
    LadderRun run = run_rung(rungs, r, c, duration, settings.front(), clock);
    best.spent += run.cpu;
    for (std::size_t k = 1; k < settings.size(); ++k) {
      if (best.met && run.cpu >= best.run.cpu) break;  // finer is dearer still
      const LadderRun finer = run_rung(rungs, r, c, duration, settings[k], clock);
      best.spent += finer.cpu;
      const LadderRow row{run, error_estimate(run, finer), {}, run.openings == finer.openings};
      best.tried.push_back(row);
      const double relative = relative_to_touch(row.estimate, finer, duration);
      const bool meets = relative <= accuracy;
      if (meets || (!best.met && (relative < best.relative || best.tried.size() == 1))) {
        best.met = meets;
        best.run = run;
        best.estimate = row.estimate;
        best.relative = relative;
      }
      if (meets) break;
      run = finer;
    }
  }
  return best;
}

}  // namespace powbench::sim
