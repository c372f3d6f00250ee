#include "sim/study/posterior.h"

#include <algorithm>

#include "core/random.h"
#include "sim/study/evolution.h"
#include "sim/study/least_squares.h"

namespace powbench::sim {
namespace {

using GoOn = std::function<bool(double done, double best)>;

constexpr double step = 1e-3;  // of the differences: far above the integrator's error, far below a posterior

/// Share of the work, for progress, at which the coarse search and the starts of least squares end.
constexpr double coarse_end = 0.2, starts_end = 0.7;

ManyResiduals residuals_at(const Misfit& motion, double tolerance) {
  return [&motion, tolerance](std::span<const std::vector<double>> points, Team& team) {
    return motion.residuals(points, tolerance, team);
  };
}

/// Where the starts of least squares come from, best first. None when told to stop.
std::vector<Candidate> coarse_search(const Misfit& motion, const PosteriorOptions& options, Team& team,
                                     const GoOn& go_on) {
  Evolution::Settings settings;
  settings.dimension = motion.dimension();
  settings.evaluations = options.evaluations;
  settings.smallest = 24;
  settings.seed = options.seed;
  Evolution coarse(settings, [&](std::span<const std::vector<double>> points, std::span<const double> give_up,
                                 Team& of) { return motion.values(points, give_up, of); });
  for (bool more = true; more;) {
    more = coarse.step(team);
    const double used = static_cast<double>(coarse.state().used) / static_cast<double>(options.evaluations);
    if (!go_on(coarse_end * std::min(1.0, used), coarse.best().value)) return {};
  }
  return coarse.state().population;
}

std::size_t measured_values(const FitProblem& problem) {
  std::size_t n = 0;
  for (const auto& m : problem.closings) n += m.touch.known() + m.seat.known() + m.overtravel_time.known();
  return n;
}

std::vector<double> normals(Random& random, std::size_t count) {
  std::vector<double> list(count);
  for (auto& v : list) v = random.normal();
  return list;
}

/// `motion` with data and prior shifted by one deviation each: a posterior sample is its minimum.
std::vector<Misfit> shifted(const Misfit& motion, int samples, std::uint64_t seed) {
  Random random(seed);
  const std::size_t measured = motion.per_closing() * motion.problem().closings.size();
  std::vector<Misfit> list;
  for (int k = 0; k < samples; ++k) {
    const auto data = normals(random, measured);
    list.push_back(motion.perturbed(data, normals(random, motion.dimension())));
  }
  return list;
}

}  // namespace

Posterior sample_posterior(const Misfit& misfit, const PosteriorOptions& options, Team& team,
                           const GoOn& go_on) {
  Posterior result;
  result.stopped = true;
  const Misfit motion = misfit.motion();
  const auto residuals = residuals_at(motion, options.tolerance);
  const auto found = coarse_search(motion, options, team, go_on);
  const auto starts = std::min(static_cast<std::size_t>(std::max(1, options.starts)), found.size());
  if (starts == 0) return result;
  const auto further = std::min(static_cast<std::size_t>(std::max(0, options.further_starts)), found.size());
  const auto fits = static_cast<double>(measured_values(motion.problem()));
  Refined best;
  for (std::size_t k = 0; k < starts + further; ++k) {
    if (k >= starts && best.sum <= fits) break;
    const std::size_t place =
        k < starts ? k * found.size() / starts : (2 * (k - starts) + 1) * found.size() / (2 * further);
    Refined r = refine(residuals, found[place].point, {.iterations = 30, .step = step}, team);
    result.ends.push_back(r.sum);
    if (k == 0 || r.sum < best.sum) best = std::move(r);
    const double share = std::min(1.0, static_cast<double>(k + 1) / static_cast<double>(starts));
    if (!go_on(coarse_end + (starts_end - coarse_end) * share, best.sum)) return result;
  }
  std::sort(result.ends.begin(), result.ends.end());
  result.misfit = best.sum;

  constexpr int near = 24;  // evaluations: a shift of one deviation is near
  constexpr int batch = 8;  // samples between two progress reports
  const Jacobian at_best = jacobian(residuals, best.point, best.residuals, step, team);
  const auto problems = shifted(motion, options.samples, options.seed);
  std::vector<std::vector<double>> bounces(problems.size());
  result.samples.resize(problems.size());
  for (int done = 0; done < options.samples; done += batch) {
    const auto first = static_cast<std::size_t>(done);
    const auto count = static_cast<std::size_t>(std::min(batch, options.samples - done));
    const auto some = std::span(problems).subspan(first, count);
    const auto at = [&](std::span<const PointOf> points) {
      return residuals_of(some, points, options.tolerance, team);
    };
    const auto found_near = refine_near(at, count, best.point, at_best, near);
    for (std::size_t k = 0; k < count; ++k) result.samples[first + k] = found_near[k].point;
    const auto of_batch =
        misfit.bounces(std::span(result.samples).subspan(first, count), options.tolerance, team);
    std::copy(of_batch.begin(), of_batch.end(), bounces.begin() + done);
    const double share = std::min(1.0, static_cast<double>(done + batch) / options.samples);
    if (!go_on(starts_end + (1 - starts_end) * share, best.sum)) return result;
  }
  std::vector<double> measured, angles;
  for (const auto& m : misfit.problem().closings) {
    measured.push_back(m.bounce.value);
    angles.push_back(m.conditions.closing_angle);
  }
  result.bounce = calibrate_bounce(bounces, measured, angles);
  result.stopped = false;
  return result;
}

}  // namespace powbench::sim
