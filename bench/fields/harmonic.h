#pragma once

#include <complex>
#include <vector>

#include "sim/magnetics/plane/cholesky.h"
#include "sim/magnetics/plane/field_problem.h"

/// Eddy currents in the steady state of one frequency, steel with its initial permeability:
///
///   (K + j w M) a = f,   J = sigma (E - j w a) in the conductors, phasors of exp(j w t).
///
/// The real factor of K + w M serves both parts: the block system preconditioned with two of its solves has all
/// eigenvalues in [1/2, 1], whatever the frequency, so damped Richardson steps of 4/3 gain a factor of three each.

namespace powbench::bench {

class Harmonic {
 public:
  /// The problem must have a conductor. Throws std::invalid_argument otherwise.
  Harmonic(const sim::FieldProblem&, double hertz);

  /// a for the load f (size + 1 entries, the last one ignored). Throws std::runtime_error where the residual does not
  /// fall to 1e-8 of the load.
  std::vector<std::complex<double>> solve(const std::vector<std::complex<double>>& load) const;

  /// M a, S/m times m.
  std::vector<std::complex<double>> mass_times(const std::vector<std::complex<double>>& a) const;

  const std::vector<double>& stiffness() const { return stiffness_; }  ///< values of K with the steel

 private:
  const sim::FieldProblem& problem_;
  double omega_;
  std::vector<double> stiffness_;
  sim::Cholesky cholesky_;
};

}  // namespace powbench::bench
