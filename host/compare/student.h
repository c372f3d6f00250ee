#pragma once

/// Student's t distribution: the coverage factor of a mean with few repeats.

namespace powbench::host {

/// Of every expanded uncertainty: P(|X| <= 2) of a normal X, erf(sqrt 2), so that k is 2 for infinite degrees of
/// freedom.
inline constexpr double coverage_probability = 0.954499736103642;

/// P(|T| <= t) for `dof` > 0 degrees of freedom, t >= 0. dof may be fractional or infinite (normal distribution).
double student_probability(double t, double dof);

/// The t with P(|T| <= t) = probability; probability in (0, 1); 2.000 for infinite dof by default. Throws
/// std::invalid_argument outside, or for dof <= 0.
double coverage_factor(double dof, double probability = coverage_probability);

}  // namespace powbench::host
