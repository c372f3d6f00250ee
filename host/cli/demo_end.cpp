#include "host/cli/demo_end.h"

#include <fmt/format.h>

#include <cmath>

#include "core/units.h"
#include "host/gather/gather.h"
#include "host/report/best_angle.h"

namespace powbench::host {

namespace {

std::string verdict_sentence(const Store& store, const CampaignInfo& campaign) {
  Outcome worst = Outcome::pass;
  std::size_t all = 0, passed = 0;
  for (const auto& [outcome, n] : store.outcomes(campaign.id, ShotKind::measured)) {
    worst = worse(worst, outcome);
    all += n;
    if (outcome == Outcome::pass) passed += n;
  }
  return fmt::format("Verdict {}: {} of {} closings are within the limits of the plan.", name(worst), passed,
                     all);
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
  return fmt::format("{}\n{}\nOpen {} in a browser: every closing beside its simulation.\n",
                     verdict_sentence(store, campaign),
                     angle_sentence(best_angle(compare_stored(store, campaign))), page);
}

}  // namespace powbench::host
