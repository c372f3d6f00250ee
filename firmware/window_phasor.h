#pragma once

#include "firmware/mains_ring.h"

/// Phasor of the mains fundamental over the newest two cycles.

namespace powbench::firmware {

struct WindowPhasor {
  float turns = 0;      ///< [0, 1): phase at the middle of the window
  float age = 0;        ///< samples from the middle of the window to the newest sample
  float amplitude = 0;  ///< unit of the samples, peak
  float offset = 0;     ///< unit of the samples
  float residual = 0;   ///< rms of everything else, of the rms of the fundamental; 0 .. 1000
};

/// Cycles in the window.
inline constexpr float window_cycles = 2.0F;

/// Z = sum w_i x_i exp(-j 2 pi f (t_i - t_m)), w = Hann over two cycles of frequency f (`cycle` samples
/// each).
///
/// At f exact, the window has its zeros on the offset, on the image of the fundamental and on every harmonic,
/// also those half way between. What is left is the mean square: sum w x^2 / sum w = A^2 / 2 + offset^2 +
/// residual^2. Range: 2 cycle + 1 samples in the history, cycle >= 16.
WindowPhasor window_phasor(const MainsRing& mains, float cycle);

}  // namespace powbench::firmware
