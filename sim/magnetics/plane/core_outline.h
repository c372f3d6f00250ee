#pragma once

#include <algorithm>

#include "sim/magnetics/magnet_shape.h"

namespace powbench::sim {

/// Edges of the core, m: of its half with three legs, of the whole with two, where what is named here at x lies
/// around the centre leg at -x, too. x = 0: middle of the centre leg; height 0: outer pole faces of the fixed half;
/// `face`: those of the moving half.
struct CoreOutline {
  bool half;          ///< x < 0 is the mirror image
  bool closed_leg;    ///< the outer leg goes through the gap
  double x1, x2, x3;  ///< centre leg, window, outer leg end here
  double yoke_bottom, window_bottom, centre_face;
  double face, window_top, yoke_top;  ///< of the moving half
  double coil_left, coil_right, coil_bottom, coil_top;
  bool ring;
  double ring_left, slot_left, slot_right, ring_bottom;  ///< ring_left: of its side in the window

  CoreOutline(const MagnetShape& s, double moving_face)
      : half(s.legs == 3),
        closed_leg(s.closed_leg != 0),
        x1(s.centre_width / 2),
        x2(x1 + s.window_width),
        x3(x2 + s.outer_width),
        yoke_bottom(-s.fixed_window - s.yoke),
        window_bottom(-s.fixed_window),
        centre_face(-s.centre_gap),
        face(moving_face),
        window_top(face + s.moving_window),
        yoke_top(window_top + s.yoke),
        coil_left(x1 + (s.window_width - s.coil_width) / 2),
        coil_right(coil_left + s.coil_width),
        coil_bottom(window_bottom + s.coil_offset),
        coil_top(coil_bottom + s.coil_height),
        ring(s.ring_share > 0),
        ring_left(x2 - s.ring_slot),
        slot_left(x2 + s.ring_share * (s.outer_width - s.ring_slot)),
        slot_right(slot_left + s.ring_slot),
        ring_bottom(-s.ring_depth) {
    // the side in the window gets thinner where the coil is in its way
    if (coil_top > ring_bottom) ring_left = std::max(ring_left, coil_right);
  }
};

}  // namespace powbench::sim
