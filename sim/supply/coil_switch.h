#pragma once

#include <array>
#include <cstdint>

/// The switch between mains and coil.

namespace powbench::sim {

/// A re-opening of the relay's own contact, s after its first touch.
struct RelayBounce {
  double open = 0;   ///< parts
  double close = 0;  ///< touches again; not after `open`: no bounce
};

/// Three kinds, one at a time; the numbers of the others are not read.
///
///   ideal   closes at once, opens at the next zero of the current
///           On a direct or rectified source it opens at once, and so does the relay.
///           With a `hold_period` it then chops, as an economiser does: off for the first part of each period, on for
///           the share `hold_duty` at its end
///   relay closes after a delay and bounces; where its contact parts an arc without voltage carries the current to
///   its
///           next zero, unless the contact has touched again by then
///   triac   conducts while its gate is driven. When the gate is released it stays on if the current has reached
///           `latching_current` in this half-wave, and then until it falls below `holding_current`; else it is off at
///           once. What flows at turn-off goes into the snubber: the current is zero from then on and its energy is
///           lost.
struct CoilSwitch {
  enum class Kind : std::uint8_t { ideal, relay, triac };
  Kind kind = Kind::ideal;
  double closing_delay = 0;  ///< s, relay: from command to first touch
  double opening_delay = 0;  ///< s, relay: from command to parting
  std::array<RelayBounce, 4> bounces{};
  double latching_current = 0;  ///< A, triac
  double holding_current = 0;   ///< A, triac; not above the latching current
  double gate_pulse = 0;        ///< s, triac: length of a gate pulse; 0: driven as long as commanded
  double gate_period = 0;       ///< s, triac: from pulse to pulse while commanded; 0: a single pulse
  double hold_period = 0;       ///< s, ideal: the economiser chops with this period; 0: no economiser
  double hold_after = 0;        ///< s, ideal: from the command to the first chop
  double hold_duty = 0.5;       ///< share of the period in which the coil is fed
};

/// Throws std::invalid_argument naming what is out of range.
void require_valid(const CoilSwitch&);

}  // namespace powbench::sim
