#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "dsp/filter/filter_design.h"
#include "dsp/signal/spectrum.h"

/// Where the core vibrates, where the contact force lives, and how much the two overlap.

namespace powbench::dsp {

struct Band {
  double low = 0, high = 0;  ///< Hz
};

struct BandQuestion {
  double pulse_width =
      1e-3;  ///< s, shortest contact whose force must survive; 99.5 % of its energy lies below 1.5 / T
  double probability = 0.01;   ///< of taking a bin without core vibration for one with
  double overlap_limit = -20;  ///< dB, beyond which a plain filter is refused
};

struct BandReport {
  std::vector<Band> core;  ///< runs of coherent bins, edges half a bin outside
  Band contact;            ///< 0 .. 1.5 over the pulse width
  double threshold = 0;    ///< of the coherence
  std::size_t closings = 0;
  /// Share of the coherent vibration's power on the force channel that lies inside the contact band, dB <= 0: what
  /// a low-pass at the end of the contact band would leave of it. Minus infinity without a core band.
  double ring_in_contact_db = 0;
  /// Share of a half-sine pulse's energy inside the core bands, dB <= 0: what a band-stop would take from it.
  double pulse_in_core_db = 0;
  bool overlaps = false;  ///< ring_in_contact_db > overlap_limit
};

/// Core and contact share a band: no filter can separate them.
class BandOverlapError : public std::runtime_error {
 public:
  explicit BandOverlapError(const BandReport&);
};

/// From the coherence of a core-vibration reference (x) and the force (y), averaged over closings aligned on the
/// core's impact. A bin belongs to the core when its coherence is above coherence_threshold and that of one of its
/// neighbours too: a single bin is what chance makes, and a Hann window shows a mode in three.
BandReport find_bands(const Coherence&, const BandQuestion& = {});

/// A zero-phase low-pass at the end of the contact band (elliptic two-pass, 0.1 / 40 dB) for a signal at `rate`.
/// Throws BandOverlapError when the bands overlap.
FilterSpec plain_filter(const BandReport&, double rate);

/// 10 lg of a share of power, 1 at most; minus infinity for none.
double decibel(double share);

/// Share of the energy of a half-sine pulse of `width` seconds that lies below `hertz`: 0.99 at 1.18 / width.
double half_sine_energy_below(double hertz, double width);

/// Share of the energy of a half-sine pulse of `width` seconds that a filter takes, dB <= 0, minus infinity for none:
/// 10 lg of integral (1 - g(f)^2) E(f) df over integral E(f) df up to 8 / width; what lies above (3e-5 of the energy)
/// counts as taken. `gain`: g at a frequency in Hz, amplitude.
double half_sine_taken_db(const std::function<double(double)>& gain, double width);

}  // namespace powbench::dsp
