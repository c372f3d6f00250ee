#include "sim/mechanics/bounce_study.h"

#include <algorithm>
#include <stdexcept>

#include "core/random.h"

namespace powbench::sim {
namespace {

double unchanged() {
  return 1;
}

void check(const BounceStudyOptions& o) {
  if (!(o.truth < o.tolerance)) throw std::invalid_argument("truth: allowed below tolerance");
  if (!(o.change > 0 && o.change <= 1e-2)) throw std::invalid_argument("change: allowed above 0 .. 0.01");
  if (o.runs < 64) throw std::invalid_argument("runs: allowed 64 and above");
}

}  // namespace

Specimen varied(Specimen s, const Factor& factor) {
  for (double* v :
       {&s.core.mass, &s.base.mass, &s.base.core_mass, &s.bridges.mass, &s.bridges.inertia, &s.bridges.gap})
    *v *= factor();
  return s;
}

RigidParts varied(RigidParts p, const Factor& factor) {
  for (double* v : {&p.core_mass, &p.core_inertia, &p.static_mass}) *v *= factor();
  for (auto& b : p.bridges)
    for (double* v : {&b.mass, &b.inertia, &b.gap[0], &b.gap[1]}) *v *= factor();
  return p;
}

BounceEnsemble bounce_ensemble(const BounceRun& run, const BounceStudyOptions& o) {
  check(o);
  Random random(o.seed);
  const Factor factor = [&] { return 1 + o.change * (2 * random.uniform() - 1); };
  std::vector<double> first, open, last;
  for (int k = 0; k < o.runs; ++k) {
    const auto s = bounce_summary(run(o.tolerance, factor), o.contact);
    first.push_back(s.first_touch);
    open.push_back(s.open_time);
    last.push_back(s.last_closing);
  }
  return {o.runs, spread(first), spread(open), spread(last)};
}

namespace {

BounceCondition twin_of(const std::vector<RigidEvent>& truth, const BounceRun& run,
                        const BounceStudyOptions& o) {
  Random random(o.seed);
  const auto twin = run(o.truth, [&] { return random.uniform() < 0.5 ? 1 - o.change : 1 + o.change; });
  return bounce_condition(twin, truth, o.change, o.end);
}

}  // namespace

TwinCondition twin_condition(const BounceRun& run, const BounceStudyOptions& o) {
  check(o);
  const auto truth = run(o.truth, unchanged);
  const auto events = std::count_if(truth.begin(), truth.end(), is_bounce);
  return {twin_of(truth, run, o), static_cast<int>(events)};
}

BounceStudy study_bounces(const BounceRun& run, const BounceStudyOptions& o) {
  check(o);
  const auto truth = run(o.truth, unchanged);
  BounceStudy study;
  study.error = bounce_error(run(o.tolerance, unchanged), truth, o.end);
  study.condition = twin_of(truth, run, o);
  study.computable = study.error.all() && study.error.diverged_at >= o.end && !study.condition.diverged;
  if (!study.computable) study.ensemble = bounce_ensemble(run, o);
  return study;
}

}  // namespace powbench::sim
