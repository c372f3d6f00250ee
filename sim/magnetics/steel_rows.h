#pragma once

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
/// the residual is that of the final curve. Throws std::invalid_argument, a sentence without a name: fewer than 4
/// rows; a number that is not finite; H or B below zero by more than 2 % of the largest (a loop); B at H = 0 above 5
/// % of the largest (a branch of a loop); a residual above 3 % of the largest B rms (no single curve).
FittedRows fit_rows(std::vector<BhRow> measured);

/// What speaks against rows that are meant to be T and A/m of a soft magnetic material, in one sentence with the
/// units that would fit; empty: nothing. Looked at are the saturation B - mu0 H (0.2 .. 2.5 T, not falling by more
/// than 5 %), the largest B / (mu0 H) (50 .. 150 000 where the curve goes beyond 1.3 T, 1e6 below; not at the last
/// row if that is above 0.9 T), the first B / (mu0 H) (1 and more) and H at
/// 1.95 T (100 A/m and more).
std::string doubt_units(const std::vector<BhRow>&);

/// B at which the curve has this H >= 0, by bisection, T.
double flux_density(const Steel&, double h);

}  // namespace powbench::sim
