#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/events.h"
#include "core/outcome.h"

namespace powbench::host {

/// Allowed range of one quantity, SI, both ends included; NaN = open end. Holds at every closing angle.
struct Limit {
  std::string quantity;  ///< symbol of the quantity table, e.g. t_ct_bon
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();

  /// PASS or FAIL by the rule; NOT OBSERVED for a value that is not known, NOT JUDGED where the rule needs an
  /// uncertainty that is not known.
  Outcome of(const Measured&, Decision = Decision::simple) const;
};

/// The closing angle reached against the one commanded, rad: PASS within the tolerance, guarded by U = 2 u where the
/// rule says so; NOT OBSERVED where none is known.
Outcome judge_angle(const Measured& reached, double commanded, double tolerance, Decision);

struct Judgement {
  Outcome outcome = Outcome::not_judged;  ///< the worst over the limits; NOT JUDGED without any
  std::string
      reason;  ///< every limit that is not met, in one line: "t_ct_bon = 9.12 ms, allowed ≤ 9 ms"; or empty
};

/// One shot against the limits. A limited quantity the record does not show (the contact never closed) is NOT OBSERVED.
/// Throws std::invalid_argument for a limit on an unknown quantity.
Judgement judge(const Events&, const std::vector<Limit>&, Decision = Decision::simple);

/// The rule in one sentence.
std::string_view decision_text(Decision);

/// "0 to 9 ms", "≤ 9 ms", "≥ 1 ms" in the unit people read (ms, mm, mA by the SI unit of the quantity).
std::string range_text(const Limit&);

}  // namespace powbench::host
