#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

/// Small non-linear and linear least squares (up to some tens of parameters).

namespace powbench::dsp {

struct LeastSquares {
  std::vector<double> x;           ///< (p) solution
  std::vector<double> covariance;  ///< (p, p) row-major: inverse of J^T J, so unit variance per residual
  double chi2 = 0.0;               ///< sum of squared residuals at x
  int iterations = 0;
  bool converged = false;

  double u(std::size_t i) const;  ///< standard uncertainty of x[i]
};

/// One parameter: start, the step for its numerical derivative (also its scale), and its range.
struct FreeParameter {
  double start = 0.0;
  double step = 1e-6;
  double lower = -1e300;
  double upper = 1e300;
};

/// Fills the residuals, each already divided by its standard deviation, at the parameters given.
using Residuals = std::function<void(std::span<const double> parameters, std::span<double> residual)>;

/// Fills d residual / d parameter, column-major (rows, p).
using Derivatives = std::function<void(std::span<const double> parameters, std::span<double> jacobian)>;

/// Levenberg-Marquardt (Marquardt scaling, ranges by clamping). `rows` residuals. Done when a step gains less than
/// `least_gain` in chi-square; 1e-6 is a thousandth of a standard uncertainty. Without `derivatives`: central
/// differences with each parameter's step.
LeastSquares levenberg_marquardt(const Residuals&, std::size_t rows, std::span<const FreeParameter>,
                                 int max_iterations = 40, const Derivatives& derivatives = {},
                                 double least_gain = 1e-6);

/// Linear least squares by column-pivoted QR. `columns` is (p) arrays of n values. Rank deficiency:
/// minimum-norm-like basic solution, covariance of dropped columns infinite.
LeastSquares linear_least_squares(std::span<const std::vector<double>> columns, std::span<const double> y);

/// The sum of squares alone that such a fit leaves, from normal equations: a fraction of the price. `columns`: the
/// `count` columns one behind the other, each of the length of y and scaled so that their sizes compare.
double linear_misfit(std::span<const double> columns, std::size_t count, std::span<const double> y);

}  // namespace powbench::dsp
