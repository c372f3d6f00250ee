#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/events.h"
#include "core/record.h"
#include "dsp/events/film_paths.h"
#include "dsp/filter/bands.h"
#include "dsp/filter/canceller.h"
#include "dsp/options.h"
#include "dsp/signal/signal.h"
#include "dsp/vibration/ring.h"

/// Core vibration on the films, for the eye: in which band it is, whether a filter could remove it, and the force
/// without it. No event is decided on these.

namespace powbench::dsp {

/// One film of one closing, before and after its vibration is taken out.
struct FilmVibration {
  bool present = false;
  double impact = 0.0;                 ///< s: core seat, else the ring's onset, else the first touch
  Signal force;                        ///< N, restored
  Signal stripped;                     ///< N, less the modes fitted together with the contacts
  Ring ring;                           ///< those modes; may be empty
  std::optional<Cancelled> cancelled;  ///< by a reference channel, when there is one; refused says why not
  std::string reference;               ///< its name
  double settled = 0.0;                ///< N, at the end; 0 when not closed
  double shortest = 1e-3;              ///< s: shortest contact seen: its force must survive a filter
};

/// `events`: those of the record. The reference is the auxiliary channel (an accelerometer) if it moves at the
/// impact, else the laser. `path`: what the extraction with these options went through, where somebody kept it.
FilmVibration film_vibration(const Record&, Channel film, const Events& events, const ExtractOptions&,
                             const FilmPath* path = nullptr);

/// Bands of one closing, from its fitted modes: each from its frequency minus to plus half its half-power width
/// (decay / pi), weighted with its energy amplitude^2 / (4 decay). `closings` is 1, `threshold` 0.
BandReport bands_of_ring(const Ring&, const BandQuestion&);

/// One closing as the band finder wants it: force and reference on one time axis, and when the core struck.
struct Closing {
  Signal force, reference;
  double impact = 0.0;
};
/// Nothing when film or reference are missing, or the core's seat is not known.
std::optional<Closing> closing_of(const Record&, Channel film, const Events&, const ExtractOptions&);

/// Bands from the coherence of reference and force over closings, 0.3 ms before the impact to 5 ms after. Nothing for
/// fewer than three closings of one rate.
std::optional<BandReport> bands_of_closings(std::span<const Closing>, const BandQuestion&);

/// Values at the times of another signal, by straight lines; masks carried over, `mask_edge` outside.
Signal on_axis_of(const Signal& s, const Signal& axis);

/// Power density against time: `frames` Hann windows of `window` seconds, evenly from `from` to `to` (centres).
struct Spectrogram {
  double t0 = 0, dt = 0;  ///< s, of the centres
  double bin_hertz = 0;   ///< Hz
  std::size_t frames = 0, bins = 0;
  std::vector<double> density;  ///< (frames, bins) unit^2 / Hz
};
/// Windows that reach beyond the record see zeros. Throws std::invalid_argument for an empty signal or span, or a
/// window of fewer than 8 samples.
Spectrogram spectrogram(const Signal&, double from, double to, double window, std::size_t frames);

}  // namespace powbench::dsp
