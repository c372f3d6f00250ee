#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "sim/magnetics/steel.h"

/// Rows of a measured curve made fit for `Steel::table`: a slip of unit found, noise taken out.

namespace powbench::sim {

struct FittedRows {
  std::vector<BhRow> rows;  ///< what `Steel::table` takes; the origin is added where it is missing
  bool smoothed = false;    ///< false: the rows as measured, sorted by H
  double rms = 0;           ///< T, of B measured - B of the curve at the same H
  double worst = 0;         ///< T, the largest of these
  double worst_h = 0;       ///< A/m, where
};

/// Rows that `Steel::table` takes as they are stay. Else the polarisation J = B - mu0 H is fitted by least squares
/// under the shape of a virgin or commutation curve without hysteresis: J rises with H, its slope first grows and
/// then falls. The point of inflection is the best of all rows. The fit is read at even steps of arsinh H and J, and
/// the residual is that of the final curve. Throws std::invalid_argument, BadRow for a single row, a sentence without a
/// name: fewer than 4 rows; a number that is not finite; H or B below zero by more than 2 % of the largest (a loop); B
/// at H = 0 above 5 % of the largest (a branch of a loop); one B in all rows; a residual above 3 % of the largest B rms
/// (no single curve).
FittedRows fit_rows(std::vector<BhRow> measured);

/// What speaks against rows in T and A/m of a soft magnetic material, in one sentence with the units that would fit in
/// place of those taken, `b_unit` T and `h_unit` A/m; empty: nothing. Looked at are the saturation B - mu0 H (0.2 ..
/// 2.5 T, not falling by more than 5 %), the largest B / (mu0 H) (50 .. 150 000 where the curve goes beyond 1.3 T, 1e6
/// below; not at the last row if that is above 0.9 T), the first B / (mu0 H) (1 and more) and H at 1.95 T (100 A/m and
/// more).
std::string doubt_units(const std::vector<BhRow>&, double b_unit = 1, double h_unit = 1);

/// What is unusual of rows that can be used, one sentence; empty: nothing. They end below the knee, or go beyond 3e5
/// A/m, or the largest permeability is below 1000.
std::string weak_rows(const std::vector<BhRow>&, const Steel& curve);

/// Of one of the measured rows.
struct BadRow : std::invalid_argument {
  std::size_t row;  ///< from 0
  BadRow(std::size_t at, const std::string& what) : std::invalid_argument(what), row(at) {}
};

/// B at which the curve has this H >= 0, by bisection, T.
double flux_density(const Steel&, double h);

}  // namespace powbench::sim
