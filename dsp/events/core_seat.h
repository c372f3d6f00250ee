#pragma once

#include "core/events.h"
#include "core/record.h"
#include "dsp/options.h"

namespace powbench::dsp {

/// Core events from the laser. The core lands where its velocity drops abruptly. Drops are the coefficients of max(t
/// - t_k, 0) beside a cubic over +-0.5 ms (m/s, least squares), above eight times their noise; the seat is the first
/// of at least half the largest one, behind a third of the travel. Around it x(t) = x_s + v (t - t_s) + a (t - t_s)^2
/// / 2 is fitted with a velocity that falls evenly over a short time from t_s on (the stop gives way by some 10 um)
/// and another acceleration after that; t_s and the duration are searched for the least residual. The travel after
/// the seat may go on, because the static core yields with the base; no plateau is assumed. The velocity is the one
/// in the laboratory just before t_s.
///
/// Later drops of more than `seat_share` of the first are landings. Contacts that press on the static core make drops
/// of up to a fifth of the first: from 0.65 `seat_share` on they are doubtful, u of `settled` and `bounce_time` holds
/// sqrt(1/2) of the distance to the last of them, and the core carries flag_resolution.
///
/// Where the auxiliary channel is an accelerometer on the base, its first sample clear of what was there before,
/// within 0.3 ms of the laser's seat, dates the impact to a sample; the laser then only says which impact it was.
/// Uncertainty: the fit's and a record sample's; with a laser slower than the record one of its own samples over
/// sqrt(3), with a slowly rising blow the time from the first level to twice that.
CoreEvents core_events(const Record&, const ExtractOptions&);

/// s: a second landing sooner than this after the first is not told apart from it. A core may strike again within it
/// (after
/// 0.15 ms on the simulated rig): `bounce_time` 0 means none later than this, and u of `settled` and `bounce_time`
/// holds this over sqrt(3).
inline double core_resolution(const ExtractOptions& o) {
  return o.seat_window;
}

}  // namespace powbench::dsp
