#include "sim/study/posterior.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "sim/study/evolution.h"
#include "sim/study/least_squares.h"

namespace powbench::sim {
namespace {

constexpr double step = 1e-3;  // of the differences: far above the integrator's error, far below a posterior

/// Shares of the work, for progress.
constexpr double coarse_share = 0.15, starts_share = 0.25;

Refined refined(const Misfit& motion, const std::vector<double>& start, int iterations, double tolerance,
                Team& team) {
  RefineOptions options;
  options.iterations = iterations;
  options.step = step;
  return refine([&](std::span<const double> p) { return motion.residuals(p, tolerance); }, start, options,
                team);
}

std::vector<double> normals(Random& random, std::size_t count) {
  std::vector<double> list(count);
  for (auto& v : list) v = random.normal();
  return list;
}

void weigh(std::vector<Posterior::Draw>& draws, const std::vector<double>& sums) {
  const double least = *std::min_element(sums.begin(), sums.end());
  double total = 0;
  for (std::size_t k = 0; k < draws.size(); ++k) total += draws[k].weight = std::exp(0.5 * (least - sums[k]));
  for (auto& d : draws) d.weight /= total;
  std::stable_sort(draws.begin(), draws.end(),
                   [](const Posterior::Draw& a, const Posterior::Draw& b) { return a.weight > b.weight; });
}

}  // namespace

Posterior sample_posterior(const Misfit& misfit, const PosteriorOptions& options, Team& team,
                           const std::function<bool(double done, double best)>& go_on) {
  Posterior result;
  result.stopped = true;
  const Misfit motion = misfit.motion();
  Evolution::Settings settings;
  settings.dimension = motion.dimension();
  settings.evaluations = options.evaluations;
  settings.smallest = 24;
  settings.seed = options.seed;
  Evolution coarse(settings,
                   [&](std::span<const double> p, double give_up) { return motion.value(p, give_up); });
  for (bool more = true; more;) {
    more = coarse.step(team);
    const double used = static_cast<double>(coarse.state().used) / static_cast<double>(options.evaluations);
    if (!go_on(coarse_share * std::min(1.0, used), coarse.best().value)) return result;
  }

  const auto& found = coarse.state().population;
  const auto starts = std::min(static_cast<std::size_t>(std::max(1, options.starts)), found.size());
  Refined best;
  for (std::size_t k = 0; k < starts; ++k) {
    constexpr int iterations = 30;
    Refined r = refined(motion, found[k * found.size() / starts].point, iterations, options.tolerance, team);
    result.ends.push_back(r.sum);
    if (k == 0 || r.sum < best.sum) best = std::move(r);
    const double share = static_cast<double>(k + 1) / static_cast<double>(starts);
    if (!go_on(coarse_share + starts_share * share, best.sum)) return result;
  }
  std::sort(result.ends.begin(), result.ends.end());
  result.misfit = best.sum;

  Random random(options.seed);
  const std::size_t measured = Misfit::per_closing * motion.problem().closings.size();
  std::vector<double> sums;
  for (int k = 0; k < options.draws; ++k) {
    constexpr int iterations = 6;  // a shift of one deviation is near
    const auto shifts = normals(random, measured);
    const Misfit shifted = motion.perturbed(shifts, normals(random, motion.dimension()));
    result.draws.push_back({refined(shifted, best.point, iterations, options.tolerance, team).point, 0});
    sums.push_back(misfit.demands(result.draws.back().point));
    const double share = static_cast<double>(k + 1) / static_cast<double>(options.draws);
    if (!go_on(coarse_share + starts_share + (1 - coarse_share - starts_share) * share, best.sum))
      return result;
  }
  weigh(result.draws, sums);
  result.stopped = false;
  return result;
}

}  // namespace powbench::sim
