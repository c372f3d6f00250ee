#pragma once

#include <string>

#include "core/events.h"
#include "dsp/filter/filter_design.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"

/// A filter on the force channels, as somebody requested it, and what it does to the time of an edge.

namespace powbench::dsp {

/// `low-pass 2 kHz zero phase`.
std::string name_of(const EventFilter&);

/// Butterworth of order 2 (band-stop: two poles a side), forward and backward for zero phase, -3 dB at the edges
/// either way; `plain`: that of plain_filter. Throws FilterDesignError where the edges do not lie inside 0 .. rate /
/// 2.
FilterSpec spec_of(const EventFilter&, double rate);

/// What the filter makes of a step of force; times in s.
struct FilterEffect {
  double delay =
      0;  ///< the filtered step reaches half its height so much later; taken out of the time axis. 0 for zero phase
  /// That taken out, from the first deviation above 3 % of the step to the step: a touch may seem as early. Half a
  /// sample at least.
  double before = 0;
  double after = 0;  ///< and from the step to the last deviation: a release may seem as late
  double swing =
      0;  ///< largest deviation behind the rise, as a share of the step, times a period of the filter's edge
          ///< (band-stop: of its middle)
  double rise = 0;  ///< from 10 % to 90 %: shorter openings are not resolved
};
FilterEffect effect_of(const EventFilter&, double rate);

/// What it adds to u of a touch and of a release, s: `before` or `after` and `swing`, root of squares, over sqrt(3).
double u_touch(const FilterEffect&);
double u_release(const FilterEffect&);

/// Amplitude of a sine at `hertz` behind the filter, 1 = untouched.
double gain_of(const EventFilter&, double hertz, double rate);

/// In place, `delay` taken out of the time axis. Clipped and lost samples take half a rise on either side with them.
/// Throws FilterMemoryError when the signal is shorter than the filter's memory (1e-3 of its peak).
void apply_filter(Signal&, const EventFilter&);

/// What the filter leaves unknown goes into u: u_touch, u_release; of a peak what a half sine
/// of the contact's length loses. Settled and bounce time follow; nothing shorter than `rise` counts as resolved.
void admit_filter(ContactTrain&, const FilterEffect&);

}  // namespace powbench::dsp
