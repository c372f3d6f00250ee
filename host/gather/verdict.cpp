#include "host/gather/verdict.h"

#include "host/gather/scene.h"
#include "host/plan/expand.h"

namespace powbench::host {

Judgement judged_anew(const StoredShot& shot, const std::optional<Events>& events,
                      const RunOptions& options) {
  Judgement judged{shot.outcome, shot.reason};
  if (!events || !measured(shot.outcome)) return judged;
  judged = judge_shot(*events, shot.conditions, options);
  if (judged.reason.empty() && judged.outcome == Outcome::not_judged) judged.reason = shot.reason;
  return judged;
}

Outcome campaign_verdict(const Store& store, const CampaignInfo& c) {
  const Plan plan = stored_plan(c);
  const RunOptions options = stored_options(c, plan);
  ReportInput input;
  input.origin = c.origin;
  input.unplanned = unplanned(c, plan);
  input.planned = input.unplanned ? 0 : expand(plan, stored_specimen(c).name).size();
  input.most_from_simulation = plan.limits_vs_simulation;
  input.limits = options.limits;
  for (const StoredShot& s : store.shots(c.id, ShotKind::measured)) {
    ReportShot shot;
    shot.outcome = judged_anew(s, store.load_events(s.id), options).outcome;
    input.shots.push_back(std::move(shot));
  }
  input.comparison = compare_stored(store, c);
  return verdict(input);
}

}  // namespace powbench::host
