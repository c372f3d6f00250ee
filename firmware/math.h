#pragma once

#include <cstdint>

/// Elementary functions of the portable core: float32, polynomials only, the same bits on every IEEE machine
/// when contraction is off. Angles are in turns (1 turn = 2 pi rad), so that reduction to one period is
/// exact.

namespace powbench::firmware {

/// x reduced to [0, 1). Exact. Range: |x| < 2^31.
float wrap_turns(float x);

/// x reduced to [-0.5, 0.5). Range: |x| < 2^31.
float wrap_half(float x);

/// sin(2 pi x), cos(2 pi x): Taylor polynomial of degree 11 on a quarter turn. Absolute error <= 2.5e-7 for
/// |x| <= 4.
float sin_turns(float x);
float cos_turns(float x);

/// Angle of (x, y) in turns, (-0.5, 0.5]; 0 for (0, 0). Error <= 6e-8 turns. y, x: any finite values.
float atan2_turns(float y, float x);

/// Correctly rounded square root; 0 for x <= 0.
float square_root(float x);

}  // namespace powbench::firmware
