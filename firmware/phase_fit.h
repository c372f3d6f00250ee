#pragma once

#include <span>

/// A parabola through a short history of phases.

namespace powbench::firmware {

struct PhasePoint {
  float turns = 0;  ///< phase less that of a steady reference, turns: small, not wrapped
  float time = 0;   ///< s, relative to the instant the fit is asked for; <= 0
};

struct PhaseFit {
  float turns = 0;  ///< at time 0
  float hertz = 0;  ///< at time 0, to be added to the reference frequency
  float rate = 0;   ///< Hz/s
  float rms = 0;    ///< turns: scatter of the points about the fit
};

/// Least squares of phi(t) = p + f t + r t^2 / 2 with the expectation that r is zero within `expected_rate`
/// (Hz/s, one standard deviation), points of variance `noise` squared (turns^2, > 0): minimises
///   sum (phi_k - phi(t_k))^2 / noise^2 + (r / expected_rate)^2.
/// Range: at least 2 points at different times.
PhaseFit fit_phase(std::span<const PhasePoint> points, float noise, float expected_rate);

}  // namespace powbench::firmware
