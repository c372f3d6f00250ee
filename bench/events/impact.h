#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "bench/dsp_synth.h"

/// A contact that closes, as an ordinary differential equation: a bridge of mass m, pressed by its spring, meets a
/// pad. Nothing here is shared with the extraction or its pulse shapes; touch and release are where the equation
/// makes and breaks contact.

namespace powbench::bench {

/// Law of the pad; d is the indentation, m; F is never below 0 unless the pad sticks.
enum class Pad : std::uint8_t {
  spring,  ///< k d
  hertz,   ///< k d^1.5
  hunt_crossley,  ///< k d^1.5 (1 + 1.5 c d' / v), v the speed at touch: restitution about 1 - c (Hunt, Crossley 1975)
  damped,    ///< k d + b d': jumps at touch, pulls before it breaks
  yielding,  ///< k d on the way in, a stiffer line on the way out, down to a dent that stays
};
std::string_view name(Pad);

struct Impact {
  Pad pad = Pad::hunt_crossley;
  double loss = 0.15;     ///< c, or the damping ratio of `damped`, or the share of the indentation that stays
  double width = 0.6e-3;  ///< s, of the first contact, about
  double peak = 10;       ///< N, of the first contact, about
  double settled = 5;     ///< N, spring force
  double first_touch = 5e-3;  ///< s after switch-on
};

struct Closing {
  std::vector<double> force;          ///< N, one a sample, from t = 0 on
  std::vector<TrueContact> contacts;  ///< s after t = 0
};

/// Integrated by Heun's rule in steps of 0.1 us, the crossings interpolated. `seconds` from t = 0, `rate` in Hz.
Closing closing_of(const Impact&, double seconds, double rate);

}  // namespace powbench::bench
