#pragma once

#include "firmware/mains_ring.h"

/// Phasor of the mains fundamental over the newest two cycles, and over the newer of the two.

namespace powbench::firmware {

struct WindowPhasor {
  float turns = 0;       ///< [0, 1): phase at the middle of the window
  float late_turns = 0;  ///< [0, 1): of the newer cycle alone: phase half a cycle after that
  float amplitude = 0;   ///< unit of the samples, peak
  float offset = 0;      ///< unit of the samples
  float residual = 0;    ///< rms of everything else, of the rms of the fundamental; 0 .. 1000
};

/// Z = sum w_i x_i exp(-j 2 pi f (t_i - t_m)), w = Hann over two cycles of frequency f (`cycle` samples
/// each), t_m the instant of the sample `middle` before the newest.
///
/// At f exact, the window has its zeros on the offset, on the image of the fundamental and on every harmonic,
/// also those half way between. What is left is the mean square: sum w x^2 / sum w = A^2 / 2 + offset^2 +
/// residual^2. Samples the same distance before and after the middle are taken together, so that one turn of
/// the reference serves both. The newer half is also summed without a weight, by the trapezoidal rule: the
/// sharpest window with zeros on offset, image and harmonics, for a mains that moves.
/// Range: 16 <= cycle <= middle - 1, 2 middle < samples in the history.
WindowPhasor window_phasor(const MainsRing& mains, float cycle, int middle);

}  // namespace powbench::firmware
