#include "bench/study/step_convergence.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/mechanics/bounce_study.h"
#include "sim/models/rigid_closing.h"

namespace powbench::bench {
namespace {

using Errors = std::array<sim::LadderTimes, StepConvergence::tolerances.size()>;

bool grows(const Errors& errors, std::size_t quantity) {
  constexpr double matters = 1e-9, allowed = 10;
  double least = errors[0][quantity];
  for (const auto& e : errors) {
    if (e[quantity] > matters && e[quantity] > allowed * least) return true;
    least = std::fmin(least, e[quantity]);
  }
  return false;
}

sim::BounceStudy bounces(const sim::Rung& rung, const sim::Case& c, double duration) {
  sim::BounceStudyOptions options;
  options.end = duration;
  return sim::study_bounces(
      [&](double tolerance, const sim::Factor& factor) {
        const sim::Case changed{sim::varied(c.specimen, factor), c.conditions, c.bench};
        return sim::contact_events(rung.run(changed, duration, tolerance, 0).events);
      },
      options);
}

void summarise(StepConvergence& result, const std::vector<Errors>& scenes) {
  for (std::size_t t = 0; t < StepConvergence::tolerances.size(); ++t)
    for (std::size_t q = 0; q < sim::ladder_quantities.size(); ++q) {
      std::vector<double> errors;
      for (const Errors& e : scenes)
        if (!std::isnan(e[t][q])) errors.push_back(e[t][q]);
      if (errors.empty()) continue;
      std::sort(errors.begin(), errors.end());
      result.median[t][q] = errors[errors.size() / 2];
      result.largest[t][q] = errors.back();
    }
}

}  // namespace

StepConvergence step_convergence(std::span<const sim::Rung> rungs, std::size_t rung,
                                 std::span<const sim::Case> scenes, double duration,
                                 const sim::CpuClock& clock) {
  StepConvergence result;
  result.rung = rung;
  std::vector<Errors> kept;
  for (const auto& scene : scenes) {
    const auto at = [&](double tolerance) {
      return sim::run_rung(rungs, rung, scene, duration, tolerance, clock);
    };
    try {
      const auto study = bounces(rungs[rung], scene, duration);
      if (study.error.reference == 0) {
        ++result.open;
        continue;
      }
      if (!study.computable) {
        ++result.not_computable;
        continue;
      }
      const auto best = at(StepConvergence::truth);
      Errors errors;
      for (std::size_t t = 0; t < errors.size(); ++t)
        errors[t] = sim::time_error(at(StepConvergence::tolerances[t]), best);
      ++result.computable;
      for (std::size_t q = 0; q < result.grew.size(); ++q) result.grew[q] += grows(errors, q);
      kept.push_back(errors);
    } catch (const std::runtime_error&) {  // a guard stopped it, and says why
      ++result.not_computable;
    }
  }
  summarise(result, kept);
  return result;
}

}  // namespace powbench::bench
