#include "host/cli/demo_end.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/counted.h"
#include "core/units.h"
#include "host/gather/gather.h"
#include "host/gather/scene.h"
#include "host/gather/verdict.h"
#include "host/report/best_angle.h"

namespace powbench::host {

namespace {

/// The verdict of the report, and what it comes from.
std::string verdict_sentence(const Store& store, const CampaignInfo& campaign, const Comparison& comparison) {
  const Plan plan = stored_plan(campaign);
  std::size_t all = 0, passed = 0;
  for (const auto& [outcome, n] : store.outcomes(campaign.id, ShotKind::measured)) {
    all += n;
    if (outcome == Outcome::pass) passed += n;
  }
  const std::vector<Limit> limits = plan_limits(plan);
  std::size_t off = 0, outside = 0;
  for (const ComparisonRow& r : comparison.rows) {
    const bool limited =
        std::any_of(limits.begin(), limits.end(), [&](const Limit& l) { return l.quantity == r.quantity; });
    off += r.against_simulation == Outcome::fail ? 1U : 0U;
    outside += limited && r.outcome == Outcome::fail ? 1U : 0U;
  }
  std::string why;
  if (!limits.empty()) why = fmt::format("{} of {} closings are within the limits of the plan", passed, all);
  if (outside > 0 && passed == all) why += fmt::format(", but {} not", counted(outside, "mean value"));
  if (off > 0)
    why += fmt::format("{}{} further from the simulation than the plan allows", why.empty() ? "" : ", but ",
                       counted(off, "mean value"));
  if (why.empty())
    why = std::isfinite(plan.limits_vs_simulation)
              ? "no mean value was found further from the simulation than the plan allows"
              : fmt::format("the plan has no limits for its {}", counted(all, "closing"));
  return fmt::format("Verdict {}: {}.", name(campaign_verdict(store, campaign)), why);
}

std::string angle_sentence(const BestAngle& best) {
  if (best.angles == 0) return "Best closing angle: not known, no bounce time was measured.";
  std::string text = fmt::format("Best closing angle {:g} deg of {} measured: it bounces for {:.2f} ms",
                                 degrees(best.angle), best.angles, best.bounce.value * 1e3);
  if (const double U = best.coverage * best.bounce.u; std::isfinite(U))
    text += fmt::format(" +- {:.2f} ms (95 %)", U * 1e3);
  if (best.gain.known())
    text += fmt::format(", {:.2f} ms less than the mean over the angles", best.gain.value * 1e3);
  if (std::isfinite(best.confidence))
    text += fmt::format("; it is the best of these with a probability of {:.0f} % or more",
                        std::floor(best.confidence * 100));
  return text + ".";
}

}  // namespace

std::string three_sentences(const Store& store, const CampaignInfo& campaign, const std::string& page) {
  const Comparison comparison = compare_stored(store, campaign);
  return fmt::format("{}\n{}\nOpen {} in a browser: every closing beside its simulation.\n",
                     verdict_sentence(store, campaign, comparison), angle_sentence(best_angle(comparison)),
                     page);
}

}  // namespace powbench::host
