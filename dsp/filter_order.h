#pragma once

#include "dsp/filter_design.h"

/// The smallest filter that does what is asked.

namespace powbench::dsp {

/// At most `pass_db` loss in the pass band and at least `stop_db` in the stop band. A low- or high-pass uses
/// the two edges called `low`; a band-pass has stop_low < pass_low < pass_high < stop_high, a band-stop
/// pass_low < stop_low < stop_high < pass_high.
struct FilterRequirement {
  FilterKind kind = FilterKind::low;
  FilterFamily family = FilterFamily::butterworth;
  double pass_low = 0, pass_high = 0;  ///< Hz
  double stop_low = 0, stop_high = 0;  ///< Hz
  double pass_db = 1, stop_db = 60;
  double rate = 0;        ///< Hz
  bool two_pass = false;  ///< the decibels are those of both passes together
};

/// Smallest order, and edges such that the pass band is met exactly and the stop band with what the integer
/// order gives on top. Throws FilterDesignError for edges out of order or out of (0, rate / 2), pass_db >=
/// stop_db, NaN, and when more than order 16 would be needed.
FilterSpec smallest_filter(const FilterRequirement&);

}  // namespace powbench::dsp
