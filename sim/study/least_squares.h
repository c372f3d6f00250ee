#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sim/team.h"

/// Local least squares in the unit cube, and what its Jacobian says about the parameters.

namespace powbench::sim {

/// Residuals at a point; always the same number of them.
using Residuals = std::function<std::vector<double>(std::span<const double> point)>;
/// The same at many points, in order: for residuals that share their work.
using ManyResiduals =
    std::function<std::vector<std::vector<double>>(std::span<const std::vector<double>> points, Team&)>;

/// d residual / d coordinate, row by row.
struct Jacobian {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// One-sided differences with `step`, taken towards the middle of the cube.
Jacobian jacobian(const ManyResiduals&, std::span<const double> point, std::span<const double> residuals,
                  double step, Team&);
/// A column for each worker at a time.
Jacobian jacobian(const Residuals&, std::span<const double> point, std::span<const double> residuals,
                  double step, Team&);

struct RefineOptions {
  int iterations = 10;
  double step = 1e-4;     ///< of the differences
  double damping = 1e-2;  ///< of the first step, relative to the largest diagonal of J^T J
  double enough = 1e-4;   ///< relative decrease of the sum below which it ends
};

struct Refined {
  std::vector<double> point;
  std::vector<double> residuals;
  double sum = 0;      ///< of squares
  int iterations = 0;  ///< of `refine_near`: evaluations
};

/// Levenberg-Marquardt; coordinates are kept in [0, 1]. Never ends higher than it began.
Refined refine(const ManyResiduals&, std::vector<double> start, const RefineOptions&, Team&);
Refined refine(const Residuals&, std::vector<double> start, const RefineOptions&, Team&);

/// A point of problem number `problem`.
struct PointOf {
  std::size_t problem = 0;
  std::vector<double> point;
};
/// Residuals of each, in order.
using ResidualsOf = std::function<std::vector<std::vector<double>>(std::span<const PointOf>)>;

/// Levenberg-Marquardt for `count` problems from one start whose Jacobian is known, kept up by Broyden's rank-one
/// update (C. G. Broyden, Math. Comp. 19, 1965, 577) in place of new differences: `evaluations` of the residuals at
/// most, where `refine` needs one for each coordinate and iteration. For minima near the start: on shifted data. None
/// ends higher than it began. The problems go on side by side, and none changes another's result.
std::vector<Refined> refine_near(const ResidualsOf&, std::size_t count, const std::vector<double>& start,
                                 const Jacobian& at_start, int evaluations);

/// What data with unit deviations and a Gaussian prior of `prior_deviation` on each coordinate say (flat prior: 0).
struct Identifiability {
  std::vector<double> deviation;  ///< posterior standard deviation of each coordinate
  std::vector<double>
      data_share;  ///< 1 - (deviation / prior)^2: 0 = the data say nothing. Flat prior: that of the unit interval of
                   ///< the
                   ///< coordinate, deviation 1 / sqrt(12)
  std::vector<double> correlation;  ///< dimension x dimension, of the posterior
  std::vector<double> singular;     ///< singular values of the Jacobian, descending
};
Identifiability identifiability(const Jacobian&, double prior_deviation);

}  // namespace powbench::sim
