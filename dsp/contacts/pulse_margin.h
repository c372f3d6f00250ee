#pragma once

#include "core/events.h"
#include "dsp/contacts/contact_fit.h"

/// Touch and release of a pulse whose shape the noise leaves open.

namespace powbench::dsp {

/// Standard uncertainty of the exponent from which on the curvature at the optimum no longer tells the width of the
/// likelihood.
inline constexpr double open_exponent = 0.1;

/// Means and standard deviations over the profile of the likelihood along the exponent p, touch, release and peak
/// fitted anew at each node of a grid:
///   weight of p_j = exp(-(chi2(p_j) + prior(p_j)) / 2),   variance = sum_j w_j (u_j^2 + (a_j - mean)^2).
/// A small exponent means a later touch and a steeper force, so an optimum that noise has pushed there looks surer
/// than it is; the sum knows the others. `best`: the optimum. Samples of [from, to], averaged to rows of 5 us.
/// `known`: two nodes or more count.
struct PulseMargin {
  Measured touch, release, peak;  ///< s, s, N
  bool known = false;
};
PulseMargin over_exponents(const Signal& force, double noise, const PulseShape& best, double from, double to,
                           const ExtractOptions&);

/// Touch, release and peak stay at the optimum; each uncertainty becomes the rms distance of the likelihood from it
/// where that is larger. `grow`: factor on it.
void use_margin(Contact&, const PulseMargin&, double grow);

}  // namespace powbench::dsp
