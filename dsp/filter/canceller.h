#pragma once

#include <string>
#include <vector>

#include "dsp/signal/signal.h"

/// Takes out of the force what a core-vibration reference explains, with one short FIR solved once for the record.

namespace powbench::dsp {

struct CancelOptions {
  std::size_t taps =
      64;           ///< of the FIR, centred: half of them look ahead. More taps begin to fit the force too
  double from = 0;  ///< s, window in which the FIR is learnt and applied, e.g. core impact .. +10 ms
  double to = 0;    ///< s
  double low_hertz =
      800;  ///< the FIR is learnt above this, where the contact force is weak; 0 = no high-pass
  double least_explained =
      0.3;  ///< share of the force's power above low_hertz that the reference must explain
};

/// An expected outcome, not an error: without a coherent reference nothing is subtracted.
struct Cancelled {
  Signal force;  ///< the input when refused
  std::vector<double>
      taps;  ///< of the path from reference to force, taps[k] weighs reference[n + size / 2 - k]
  double explained =
      0;  ///< share of the force's power above low_hertz in the window, as the FIR sees it, less
          ///< the share that as many taps take from unrelated noise; 0 .. 1
  bool refused = false;
  std::string reason;  ///< when refused
};

/// Least squares, min sum (force - sum h[k] reference)^2 over the unmasked samples of the window, both signals
/// high-passed forward and backward by the same filter. Throws std::invalid_argument for different rates or time
/// axes (resample first), taps outside 1 .. 1024, or a window outside the record; refuses windows with fewer than
/// 4 samples a tap.
Cancelled cancel_reference(const Signal& force, const Signal& reference, const CancelOptions&);

}  // namespace powbench::dsp
