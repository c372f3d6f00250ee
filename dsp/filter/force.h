#pragma once

#include <optional>
#include <span>

#include "dsp/options.h"
#include "dsp/signal/signal.h"

/// Front end of a force channel: from charge-amplifier counts to contact force with its DC restored.

namespace powbench::dsp {

struct Force {
  bool present = false;     ///< the channel exists and is alive
  Signal signal;            ///< N, offset and hum removed, droop undone, contact force positive
  double noise = 0.0;       ///< N: standard deviation of one sample's noise
  double wander = 0.0;      ///< N rms: how far its zero goes within a millisecond beyond what is taken out
  double settled = 0.0;     ///< N: median at the end of the hold time; 0 when not closed
  double delay = 0.0;       ///< s: of the channel, already taken out of the time axis; 0 = not known
  std::uint32_t flags = 0;  ///< flag_no_hum_fit, flag_polarity
};

/// Undoes the one-pole high-pass of a charge amplifier (bilinear, corner `corner_hertz`), in place:
/// x[n] = (1 + w) y[n] + 2 w sum_{k<n} y[k], w = tan(pi corner dt). The zero level must have been removed
/// before.
void undo_droop(std::span<double> y, double corner_hertz, double dt);

/// End of what counts as one closing: the end of the record or of the hold time, whichever is first, s.
double closing_end(const Record&, const Signal&);

/// Takes the other film's force out of this one's. Film a shows F_a + p F_b, film b shows F_b + q F_a; so
/// F_a = (a - p b) / (1 - p q). `own_share` is p, `other_share` is q, both below 0.5 in size; `other` is as restored,
/// not unmixed. Samples where the other film was lost are masked as lost. Nothing happens where one of both is not
/// present.
void unmix(Force& force, const Force& other, double own_share, double other_share);

/// From counts to force: offset and hum (fitted on the time before anything touches, refused with less than
/// `min_hum_periods`), droop, sign, then the other film's share; last the filter of the options, where it was judged.
/// A record without pre-trigger takes its first 0.5 ms (at most a fiftieth) for zero and carries flag_no_hum_fit.
/// `mains_hertz`: fitted on the mains channel, or nothing (then it is fitted on the hum itself when that
/// stands out).
Force restore_force(const Record&, Channel, const ExtractOptions&, std::optional<double> mains_hertz);

}  // namespace powbench::dsp
