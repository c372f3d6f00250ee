#pragma once

#include <cstddef>
#include <span>
#include <vector>

/// Which measurement tells most about a device of which posterior samples are known.

namespace powbench::sim {

struct Informative {
  std::size_t candidate = 0;
  double bits = 0;    ///< expected information about the device, given the candidates before it
  double spread = 0;  ///< of the samples' values, given the candidates before it; in the unit of the values
  std::vector<double> left;  ///< variance of every candidate's values once this one is known too
};

/// The candidates in the order of what they add: each time the one with the largest expected mutual information
///   I = 1/2 log2(1 + v / u^2)
/// of a value that is measured with deviation u and the device, v the variance of the samples' values given what was
/// chosen before (D. V. Lindley, Ann. Math. Stat. 27, 1956, 986; for normal distributions: pivoted Cholesky). None
/// twice: its deviation is mostly the model's, which repeats do not average.
/// `samples`: values of every candidate, all finite, two samples or more; `u`: of each candidate, > 0, infinite for one
/// that is only watched. At most `count`; what tells nothing is left out.
std::vector<Informative> most_informative(std::span<const std::vector<double>> samples,
                                          std::span<const double> u, std::size_t count);

}  // namespace powbench::sim
