#pragma once

/// Every number of a magnet's shape once.
/// Columns: member of MagnetShape | key | SI per unit of the key | lowest | highest | meaning
#define POWBENCH_MAGNET_SHAPE(X)                                                                             \
  X(centre_width, "centre_width_mm", 1e-3, 2, 200, "centre leg of the core")                                 \
  X(outer_width, "outer_width_mm", 1e-3, 1, 100, "each outer leg")                                           \
  X(window_width, "window_width_mm", 1e-3, 1, 200, "between centre and outer leg")                           \
  X(fixed_window, "fixed_window_mm", 1e-3, 2, 300, "height of the window in the fixed half")                 \
  X(moving_window, "moving_window_mm", 1e-3, 0, 300,                                                         \
    "height of the window in the moving half; 0: flat armature")                                             \
  X(yoke, "yoke_mm", 1e-3, 1, 100, "height of both yokes")                                                   \
  X(stack, "stack_mm", 1e-3, 1, 300, "depth of the lamination stack")                                        \
  X(stack_factor, "stack_factor", 1, 0.5, 1, "share of iron in the stack")                                   \
  X(coil_width, "coil_width_mm", 1e-3, 0.5, 200, "section of the winding in one window")                     \
  X(coil_height, "coil_height_mm", 1e-3, 0.5, 300, "section of the winding in one window")                   \
  X(coil_offset, "coil_offset_mm", 1e-3, 0, 100, "from the bottom of the fixed window to the winding")       \
  X(ring_share, "ring_share", 1, 0, 0.95, "of each outer leg inside the shading ring; 0: no ring")           \
  X(ring_depth, "ring_depth_mm", 1e-3, 0.2, 100, "depth of the ring's slot below the pole face")             \
  X(ring_slot, "ring_slot_mm", 1e-3, 0.2, 20, "width of the ring's slot")                                    \
  X(centre_gap, "centre_gap_mm", 1e-3, 0, 2, "by which the fixed centre leg is shorter than the outer legs") \
  X(legs, "legs", 1, 2, 3, "3: E-core, 2: U-core with the coil on the centre leg")                           \
  X(closed_leg, "closed_leg", 1, 0, 1, "1: of two legs the outer one has no gap, a C-core")
