#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "host/import/suggest.h"

/// What a column of a foreign file looks like, where neither name nor unit says what it is.

namespace powbench::host {

/// What a column looks like; values thinned to a few thousand.
struct TraceShape {
  double low = 0, high = 0;
  double sine_early = 0,
         sine_late = 0;  ///< share of the variance that a sine of 40 to 70 Hz explains, first and last third
  double early = 0, late = 0;  ///< rms about the mean: first fifth, but not behind switch-on, and last third
  double start = 0, end = 0;   ///< mean of the first and the last tenth
  double last = 0;             ///< rms of the last fifth about its mean
  double middle = 0;           ///< mean of the last third
  double between = 1;          ///< share of samples that are near neither start nor end
  double beyond = 0;           ///< largest excursion outside start .. end, of their distance
  double inrush = 1;           ///< largest swing from the start, of the largest in the last fifth
  double rise = 0;             ///< from a tenth to nine tenths of the way from start to end, s
  double passing = 0;  ///< time near neither start nor end, but at most `rise`, s: a flicker before is none
  double slowing = 1;  ///< second half of that way, of its first, in time: below 1 it quickens
  double span() const { return high - low; }
  double distance() const { return std::abs(end - start); }
  /// A sine of mains frequency to its end, of volts or more: no film shows such a one.
  bool is_mains() const { return sine_late > 0.9 && span() > 2; }
  /// Rest, and rest on another level.
  bool arrives() const {
    return distance() > 0.6 * span() && last < 0.1 * distance() && early < 0.1 * distance();
  }
};

/// The part of a record that a closing is judged by, s on its time column; what is not known stays infinite.
struct CoilOn {
  double from = std::numeric_limits<double>::infinity(), to = std::numeric_limits<double>::infinity();
};

/// Nothing: too few samples. What comes at or behind `on.to` is left out.
std::optional<TraceShape> shape_of(const std::vector<double>& time, const std::vector<double>& column,
                                   const CoilOn& on = {});

/// When a column that rests at its beginning and, on the same level, at its end leaves what it did in between
/// (dsp/events/switch_off.h); infinite where it does not.
double returns_at(const std::vector<double>& time, const std::vector<double>& column);

/// What only one channel looks like.
struct Looks {
  Channel channel;
  Sureness sure;
  const char* why;
};

/// s. A core takes milliseconds from rest to its stop, and is fastest there; a contact voltage falls within a sample or
/// two.
inline constexpr double slow_rise = 1e-3;

/// Nothing: no channel looks so, or more than one.
std::optional<Looks> shaped(const TraceShape&);

}  // namespace powbench::host
