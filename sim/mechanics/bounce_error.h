#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sim/mechanics/rigid_contactor.h"

/// How far a bounce sequence can be believed. Three numbers belong together: how many events agree with a reference,
/// the largest time difference among those, and the time for which contact states disagree, which stays meaningful
/// when a grazing touch appears or vanishes. A condition number gives the amplification of input errors; a sequence
/// that is not computable is described by an ensemble.

namespace powbench::sim {

struct BounceError {
  int matched = 0;         ///< events before the first disagreement, in order, per contact
  int reference = 0;       ///< events of the reference
  double largest_dt = 0;   ///< s, among the matched
  double diverged_at = 0;  ///< s, first disagreement; the end of the run where there is none
  double distance = 0;     ///< s, worst contact's integral of |state - reference state| over the run
  bool all() const { return matched == reference; }
};

/// True for what a bench can see: pads and pole faces.
bool is_bounce(const RigidEvent&);

/// Compares the events of contacts for which `counts` is true, up to the time `end`. Two events agree if they are of
/// the same kind and at most `window` s apart.
BounceError bounce_error(std::span<const RigidEvent> events, std::span<const RigidEvent> reference,
                         double end, double window = 2e-4,
                         const std::function<bool(const RigidEvent&)>& counts = is_bounce);

/// largest_dt of a twin run over the relative change of its input: seconds of event time per unit of relative input.
/// No digit below condition * (input uncertainty) may be claimed. `diverged`: the twin left the sequence.
struct BounceCondition {
  double per_input = 0;  ///< s
  bool diverged = false;
  double horizon = 0;  ///< s, where the twin diverged, or the end of the run
};
BounceCondition bounce_condition(std::span<const RigidEvent> twin, std::span<const RigidEvent> base,
                                 double change, double end);

/// Mean and quantiles of one quantity over an ensemble.
struct Spread {
  double mean = 0, low = 0, median = 0, high = 0;  ///< 5 %, 50 % and 95 % quantile
};
Spread spread(std::vector<double> values);

/// First touch, total time open after it, and last closing of one contact.
struct BounceSummary {
  double first_touch = 0, open_time = 0, last_closing = 0;
};
BounceSummary bounce_summary(std::span<const RigidEvent>, int contact);

}  // namespace powbench::sim
