#include "sim/study/fit.h"

#include <algorithm>

#include "core/random.h"

namespace powbench::sim {
namespace {

FitMember member(const Misfit& misfit, std::vector<double> point, double value) {
  FitMember m;
  m.specimen = misfit.specimen(point);
  m.point = std::move(point);
  m.misfit = value;
  return m;
}

ManyResiduals residuals_of(const Misfit& misfit, double tolerance) {
  return [&misfit, tolerance](std::span<const std::vector<double>> points, Team& team) {
    return misfit.residuals(points, tolerance, team);
  };
}

/// Least squares from a point; kept only if the whole misfit, jumps included, has become smaller.
FitMember polished(const Misfit& misfit, const Candidate& start, const FitOptions& options, Team& team) {
  RefineOptions refine_options;
  refine_options.iterations = 6;
  Refined r = refine(residuals_of(misfit, options.tolerance), start.point, refine_options, team);
  const double value = misfit.value(r.point);
  if (value < start.value) return member(misfit, std::move(r.point), value);
  return member(misfit, start.point, start.value);
}

FitMember shifted_fit(const Misfit& misfit, const std::vector<Candidate>& population, int number,
                      const FitOptions& options, Team& team) {
  Random random(options.seed * 1000 + static_cast<std::uint64_t>(number));
  std::vector<double> shifts(misfit.per_closing() * misfit.problem().closings.size());
  for (auto& s : shifts) s = random.normal();
  const Misfit shifted = misfit.perturbed(shifts);
  Candidate start;
  start.value = 1e300;
  for (const auto& c : population) {
    const double value = shifted.value(c.point, start.value);
    if (value < start.value) start = {c.point, value};
  }
  RefineOptions refine_options;
  refine_options.iterations = 2;
  Refined r = refine(residuals_of(shifted, options.tolerance), start.point, refine_options, team);
  const double moved = shifted.value(r.point);
  const auto& point = moved < start.value ? r.point : start.point;
  return member(misfit, point, misfit.value(point));
}

}  // namespace

FitResult fit(const Misfit& misfit, const FitOptions& options, Team& team, const FitWatch& watch,
              const Evolution::State* resume, std::vector<std::vector<double>> start) {
  Evolution::Settings settings;
  settings.dimension = misfit.dimension();
  settings.evaluations = options.evaluations;
  settings.seed = options.seed;
  settings.smallest = 24;
  settings.population = options.population;
  Evolution search(
      settings,
      [&](std::span<const std::vector<double>> points, std::span<const double> give_up, Team& of) {
        return misfit.values(points, give_up, of);
      },
      std::move(start));
  if (resume != nullptr) search.resume(*resume);
  FitResult result;
  // stopped right after its last generation, a search has nothing left to do
  for (bool more = resume == nullptr || resume->used < options.evaluations; more && !result.stopped;) {
    more = search.step(team);
    if (watch.save) watch.save(search.state());
    if (watch.go_on && !watch.go_on(search.state().used, options.evaluations, search.best().value))
      result.stopped = true;
  }
  const auto& population = search.state().population;
  result.evaluations = search.state().used;
  result.best = member(misfit, population.front().point, population.front().value);
  if (result.stopped) return result;
  for (int k = 0; k < options.polished && static_cast<std::size_t>(k) < population.size(); ++k) {
    FitMember m = polished(misfit, population[static_cast<std::size_t>(k)], options, team);
    if (m.misfit < result.best.misfit) result.best = std::move(m);
  }
  for (int k = 0; k < options.ensemble; ++k)
    result.ensemble.push_back(shifted_fit(misfit, population, k, options, team));

  const auto data = [&](std::span<const std::vector<double>> points, Team& of) {
    auto all = misfit.residuals(points, options.tolerance, of);
    for (auto& r : all) r.resize(misfit.per_closing() * misfit.problem().closings.size());
    return all;
  };
  const auto at_best = data(std::span(&result.best.point, 1), team).front();
  result.sensitivity = jacobian(data, result.best.point, at_best, 1e-4, team);
  const double uniform = misfit.problem().prior_deviation;
  result.identifiability = identifiability(result.sensitivity, uniform);
  return result;
}

}  // namespace powbench::sim
