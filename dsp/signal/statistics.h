#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Robust statistics and the one smoothing kernel that never overshoots.

namespace powbench::dsp {

double median(std::span<const double>);  ///< NaN when empty

/// Standard deviation of white noise from the median absolute deviation (times 1.4826). 0 when empty.
double robust_sigma(std::span<const double>);

/// Quantile of chi-square over its degrees of freedom (Wilson and Hilferty 1931). dof >= 1.
double reduced_chi2_quantile(double p, double dof);

/// Convolution with a unit-area Gaussian cut at 4 standard deviations; ends extended by their last value.
/// A positive kernel cannot overshoot, so it cannot invent a contact beside a tall pulse.
std::vector<double> gaussian_smooth(std::span<const double>, double sigma_samples);

/// Nearly the same in constant time per sample: three running means in a row. Ends as zero.
std::vector<double> bell_mean(std::span<const double>, double sigma_samples);

/// Factor by which gaussian_smooth lowers the standard deviation of white noise: sqrt(sum of squared
/// weights).
double gaussian_noise_gain(double sigma_samples);

}  // namespace powbench::dsp
