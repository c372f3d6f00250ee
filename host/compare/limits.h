#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/events.h"
#include "core/outcome.h"

namespace powbench::host {

/// Allowed range of one quantity, SI, both ends included; NaN = open end. Holds at every closing angle.
struct Limit {
  std::string quantity;  ///< symbol of the quantity table, e.g. t_ct_bon
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();

  /// Simple acceptance: the value itself decides, uncertainty is reported beside it. Unknown values are outside.
  bool allows(const Measured&) const;
};

struct Judgement {
  Outcome outcome = Outcome::pass;  ///< pass or fail
  std::string reason;  ///< every broken limit in one line: "t_ct_bon = 9.12 ms, allowed ≤ 9 ms"; or empty
};

/// One shot against the limits. A limited quantity the record does not show (the contact never closed) breaks its limit.
/// Throws std::invalid_argument for a limit on an unknown quantity.
Judgement judge(const Events&, const std::vector<Limit>&);

/// "0 to 9 ms", "≤ 9 ms", "≥ 1 ms" in the unit people read (ms, mm, mA by the SI unit of the quantity).
std::string range_text(const Limit&);

}  // namespace powbench::host
