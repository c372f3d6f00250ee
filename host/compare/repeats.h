#pragma once

#include <limits>
#include <vector>

#include "core/events.h"

/// Repeats of one quantity under one set of conditions: mean, scatter, combined uncertainty, modes.

namespace powbench::host {

/// After the Guide to the expression of uncertainty in measurement (JCGM 100:2008), clauses 4.2, 5.1 and G.4:
///   mean   x = sum x_i / n,  scatter s with n - 1
///   u_A    s / sqrt(n), n - 1 degrees of freedom; none for n = 1
///   u_B root mean square of the events' own u: taken as common to all repeats (calibration, delay, threshold), so it
///          does not shrink with n. Its random share is in s as well: u errs to the safe side
///   u      sqrt(u_A^2 + u_B^2)
///   dof    Welch-Satterthwaite with u_B of infinite dof: (n - 1) (u / u_A)^4
///   k      two-sided 95.45 % quantile of Student's t with dof; U = k u
struct Repeats {
  int n = 0;  ///< known values
  double mean = std::numeric_limits<double>::quiet_NaN();
  double scatter = std::numeric_limits<double>::quiet_NaN();  ///< s; NaN for n < 2
  double u = std::numeric_limits<double>::quiet_NaN();        ///< NaN when neither u_A nor u_B is known
  double dof = std::numeric_limits<double>::infinity();
  double coverage = std::numeric_limits<double>::quiet_NaN();  ///< k
  double lowest = std::numeric_limits<double>::quiet_NaN();
  double highest = std::numeric_limits<double>::quiet_NaN();
  bool two_modes = false;  ///< see `splits_in_two`
};

/// Values that are not known are left out.
Repeats repeats_of(const std::vector<Measured>&);

/// The values fall into two groups of at least two each, and the empty stretch between them is wider than five times
/// the spread within either group and than five times `u`: a mean would describe neither. Needs four values.
bool splits_in_two(std::vector<double> values, double u);

}  // namespace powbench::host
