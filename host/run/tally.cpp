#include "host/run/tally.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/quantities.h"

namespace powbench::host {

std::vector<LimitTally> tally_of(const std::vector<Limit>& limits) {
  std::vector<LimitTally> list;
  for (const Limit& limit : limits) list.push_back({.limit = limit});
  return list;
}

void count(std::vector<LimitTally>& list, const Events& events, Decision rule, double angle_deg) {
  for (LimitTally& t : list) {
    const Quantity* q = find_quantity(t.limit.quantity);
    if (q == nullptr) continue;
    const Measured m = q->of(events);
    const Outcome o = t.limit.of(m, rule);
    if (o == Outcome::not_observed) ++t.not_observed;
    if (o != Outcome::fail) continue;
    ++t.failed;
    // how far outside; a guarded value may fail while it is inside
    const auto outside = [&](double x) {
      return std::max(std::isfinite(t.limit.low) ? t.limit.low - x : -HUGE_VAL,
                      std::isfinite(t.limit.high) ? x - t.limit.high : -HUGE_VAL);
    };
    if (std::isfinite(t.worst) && outside(m.value) <= outside(t.worst)) continue;
    t.worst = m.value;
    if (rule == Decision::guarded) t.worst_u = m.u;
    t.worst_angle_deg = angle_deg;
  }
}

std::string sentence(const LimitTally& t) {
  if (t.failed == 0 && t.not_observed == 0) return {};
  std::string text = fmt::format("{}, allowed {}:", t.limit.quantity, range_text(t.limit));
  if (t.failed > 0) {
    const Quantity* q = find_quantity(t.limit.quantity);
    const bool milli = q != nullptr && q->unit == "s";
    text += fmt::format(" {} FAIL, furthest {:#.5g} {}", t.failed, milli ? t.worst * 1e3 : t.worst,
                        milli          ? "ms"
                        : q != nullptr ? q->unit
                                       : "");
    if (std::isfinite(t.worst_u))
      text +=
          fmt::format(" with U = {:.2g} {} (guarded: must be inside by U)", (milli ? 2e3 : 2.0) * t.worst_u,
                      milli          ? "ms"
                      : q != nullptr ? q->unit
                                     : "");
    if (std::isfinite(t.worst_angle_deg)) text += fmt::format(" at {:g} deg", t.worst_angle_deg);
  }
  if (t.not_observed > 0) text += fmt::format("{} {} NOT OBSERVED", t.failed > 0 ? ";" : "", t.not_observed);
  return text;
}

}  // namespace powbench::host
