#pragma once

/// The laminated core seen from the side, as the field rungs mesh it. A fixed and a moving half face each other across
/// the gap. All lengths in m.
///
/// Three legs: the fixed half is E-shaped (centre leg in the coil), the moving one E- or I-shaped.
///
///        |<------------ 2 outer + 2 window + centre ----------->|
///   moving half    +---------------------------------------------+   yoke
///                  |  outer |  window  | centre | window | outer |   moving_window (0: a flat I-shaped armature)
///                  +--------+          +--------+        +-------+
///                      ^ gap, the same at all legs
///                  +--------+          +--------+        +-------+
///                  |[ring]  |   coil   |        |  coil  | [ring]|   fixed_window
///                  |                                             |   yoke
///                  +---------------------------------------------+
///
/// The ring encloses the inner `ring_share` of each outer leg's width, in a slot `ring_depth` below the pole face.
///
/// Two legs: the right half of that picture with the whole centre leg, so the coil lies outside of it, too. A U-core;
/// with a `closed_leg` a C-core: the outer leg goes through, its iron gets longer with the gap, and one gap is left.
///
///             +--------+--------------+                +--------+--------------+
///             | centre |  window      |                |        |              |
///             +--------+       +------+                +--------+       |      |
///                 ^ gap                                    ^ gap        |      |
///             +--------+       +------+                +--------+       |      |
///        coil |        | coil  |[ring]|           coil |        | coil  |      |
///             |                       |                |                       |
///             +-----------------------+                +-----------------------+

namespace powbench::sim {

struct MagnetShape {
  double centre_width = 15.2e-3;   ///< centre leg; with `stack` this is the pole area A_c
  double outer_width = 7.6e-3;     ///< each outer leg
  double window_width = 9.0e-3;    ///< between centre and outer leg
  double fixed_window = 17.0e-3;   ///< height of the window in the fixed half
  double moving_window = 14.0e-3;  ///< height of the window in the moving half; 0: I-shaped armature
  double yoke = 7.6e-3;            ///< height of both yokes
  double stack = 18.0e-3;          ///< depth of the lamination stack, iron and insulation
  double stack_factor = 0.95;      ///< share of iron in the stack
  double coil_width = 7.0e-3;      ///< of the winding's section in one window
  double coil_height = 15.0e-3;
  double coil_offset = 1.0e-3;  ///< from the bottom of the fixed window to the winding
  double ring_share = 0.648;    ///< of each outer leg's width inside the ring; 0: no ring
  double ring_depth = 3.0e-3;   ///< slot depth below the pole face
  double ring_slot = 2.0e-3;    ///< slot width
  double centre_gap = 0;        ///< by which the fixed centre leg is shorter than the outer legs
  int legs = 3;                 ///< 3: E-core, 2: U- or C-core
  int closed_leg = 0;           ///< 1: of two legs, the outer one has no gap: C-core

  int outer_legs() const { return legs - 1; }

  bool operator==(const MagnetShape&) const = default;
};

}  // namespace powbench::sim
