#pragma once

#include <memory>
#include <vector>

#include "sim/magnetics/plane/newton.h"
#include "sim/magnetics/potential.h"

/// The finite elements of a magnet at one gap, and what is read from a solution there. SI.

namespace powbench::sim {

/// One solved state.
struct FieldPoint {
  MagneticResponse response;
  double stress_pull =
      0;  ///< N: Maxwell's stress in one layer of the air; its distance to `pull` is an error estimate
  double largest_field = 0;  ///< T, in the steel
  bool beyond_data = false;  ///< some steel is above Steel::data_end: part of its curve is extrapolated
  NewtonReport newton;
  std::vector<double> a;  ///< the solution, for pictures and for the next start
};

/// Of a solution with given fluxes.
struct FluxSlopes {
  std::vector<double> flux_flux;              ///< d i_k / d psi_l by rows
  std::vector<std::vector<double>> tangents;  ///< da/dpsi_k
};

class GapField {
 public:
  virtual ~GapField() = default;

  /// Shares nothing that changes: for another gap, or another thread.
  virtual std::unique_ptr<GapField> copy() const = 0;

  /// m, >= 0; the residual gap is added. Throws std::invalid_argument for a gap that cannot be.
  virtual void set_gap(double gap) = 0;

  /// The steels with air in place of what saturates.
  virtual std::vector<Steel> air_steels() const;

  const FieldProblem& problem() const { return problem_; }
  void set_steels(std::vector<Steel> steels) { problem_.set_steels(std::move(steels)); }
  bool has_ring() const { return problem_.setup().windings.size() > 1; }

  /// One for the coil with this flux, and one for the ring: with its flux, or `ring_open` and without current.
  std::vector<Circuit> with_fluxes(double psi, double ring, bool ring_open) const;
  std::vector<Circuit> with_currents(double current, double ring_current) const;

  /// The state in the field a with the energy E(a). Without `slopes` its second derivatives stay zero, with them all
  /// but `pull_gap` are there.
  FieldPoint point(std::vector<double> a, double energy, const std::vector<double>& current,
                   const NewtonReport&, const FluxSlopes* slopes = nullptr) const;

  /// Flux linkages of a state: coil and ring, with leakage.
  std::pair<double, double> fluxes(const FieldPoint&) const;

 protected:
  /// `coil_leakage`, `ring_leakage`: H, in series with the windings.
  explicit GapField(FieldProblem problem, double coil_leakage = 0, double ring_leakage = 0)
      : problem_(std::move(problem)), leakage_{coil_leakage, ring_leakage} {}
  GapField(const GapField&) = default;

  FieldProblem problem_;

 private:
  /// Pull in the field a, N, and its derivative by a.
  virtual double pull(const std::vector<double>& a, std::vector<double>& slope) const = 0;
  virtual double stress_pull(const std::vector<double>& a) const = 0;

  std::vector<double> leakage_;
};

/// The state in these circuits, from `start` on (a solution near by, or empty). With the coil's flux given its second
/// derivatives are there, all but `pull_gap`. `newton` is that of the field's problem.
FieldPoint state_in(const std::vector<Circuit>&, const GapField&, Newton& newton, std::vector<double> start,
                    const NewtonOptions&);

}  // namespace powbench::sim
