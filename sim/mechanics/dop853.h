#pragma once

#include "sim/mechanics/dop853_tableau.h"

/// The sums of the 8(5,3) Runge-Kutta method over flat, aligned arrays: no allocation, no branch. Arrays hold `n`
/// rounded up to a multiple of `lanes` values and start on `alignment` bytes; slope j begins at k + j * stride.
/// Bits do not depend on the vector width of the machine.

namespace powbench::sim::dop853 {

inline constexpr int lanes = 8;
inline constexpr int alignment = 64;  ///< bytes

constexpr int padded(int n) {
  return (n + lanes - 1) / lanes * lanes;
}

/// out = y + h sum_j a[row][j] k_j, row 1 .. 15: the argument of a slope; row 12 is the result of the step.
void argument(int row, int n, double h, const double* y, const double* k, int stride, double* out);
void argument(int row, int n, long double h, const long double* y, const long double* k, int stride,
              long double* out);

/// Error of a step in units of the tolerance: h e5^2 / sqrt((e5^2 + 0.01 e3^2) count), with the norms weighted by
/// `inverse` = 1 / (tolerance scale); `count` states carry weight.
double error(int n, int count, double h, const double* k, int stride, const double* inverse);
long double error(int n, int count, long double h, const long double* k, int stride,
                  const long double* inverse);

/// Seven rows of the dense output, row r at rows + r * stride; slopes 0 .. 15 are needed.
void dense_rows(int n, double h, const double* y0, const double* y1, const double* k, int stride,
                double* rows);
void dense_rows(int n, long double h, const long double* y0, const long double* y1, const long double* k,
                int stride, long double* rows);

/// State at the share `x` (0 .. 1) of the step.
void dense_state(int n, double x, const double* y0, const double* rows, int stride, double* out);
void dense_state(int n, long double x, const long double* y0, const long double* rows, int stride,
                 long double* out);

}  // namespace powbench::sim::dop853
