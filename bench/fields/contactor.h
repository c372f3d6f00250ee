#pragma once

#include "sim/magnetics/plane/magnet_field.h"

/// The E-E contactor of the reference rows: planar, 15 mm deep, the centre leg 0.1 mm short, one turn.

namespace powbench::bench {

inline sim::MagnetDesign reference_contactor() {
  sim::MagnetDesign d;
  auto& s = d.shape;
  s.centre_width = 12e-3;
  s.outer_width = 7e-3;
  s.window_width = 9e-3;
  s.fixed_window = 22e-3;
  s.moving_window = 6e-3;
  s.yoke = 7e-3;
  s.stack = 15e-3;
  s.stack_factor = 1;
  s.coil_width = 7e-3;
  s.coil_height = 18e-3;
  s.coil_offset = 1e-3;
  s.ring_share = 0;
  s.centre_gap = 0.1e-3;
  d.steel = sim::builtin_steel("reference");
  d.turns = 1;
  d.residual_gap = 1e-6;  // the rows give the whole outer gap: take it off
  return d;
}

struct ReferenceRow {
  double gap, ampere_turns, flux, pull;  ///< m, A, Wb a turn, N
};

/// Quadratic elements, 265 295 unknowns, converged to 0.006 % in the pull.
inline constexpr ReferenceRow reference_rows[] = {
    {5e-3, 300, 2.38160964e-05, 0.224265},       {5e-3, 1000, 7.93781132e-05, 2.491321},
    {5e-3, 3000, 2.36698813e-04, 22.179523},     {2e-3, 300, 3.51646848e-05, 1.392470},
    {2e-3, 1000, 1.17165589e-04, 15.458899},     {2e-3, 3000, 3.21638970e-04, 117.872120},
    {0.5e-3, 300, 8.46458300e-05, 17.832086},    {0.5e-3, 1000, 2.72310301e-04, 184.538065},
    {0.5e-3, 3000, 3.86442321e-04, 375.576975},  {0.1e-3, 300, 2.37520658e-04, 195.303566},
    {0.1e-3, 1000, 3.53534002e-04, 424.976389},  {0.1e-3, 3000, 3.98819889e-04, 518.342378},
    {0.02e-3, 300, 3.04161406e-04, 347.561657},  {0.02e-3, 1000, 3.60819285e-04, 475.859503},
    {0.02e-3, 3000, 4.00758572e-04, 556.366428},
};

}  // namespace powbench::bench
