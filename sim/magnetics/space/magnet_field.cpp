#include "sim/magnetics/space/magnet_field.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/magnetics/space/force.h"

namespace powbench::sim::space {
namespace {

constexpr double first_gap = 1e-3;  // m: strip as meshed

void require(const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument(std::string(key) + " = " + std::to_string(value) + ", allowed " +
                              std::to_string(low) + " .. " + std::to_string(high));
}

const MagnetDesign& checked(const MagnetDesign& d) {
  require("magnet.residual_gap_um", d.residual_gap * 1e6, 0.05, 1000);
  require("coil.turns", d.turns, 1, 1e6);
  return d;
}

Moving moving_core(const MagnetDesign& d, const CoreMeshSizes& sizes) {
  Moving m{core_problem(checked(d), sizes, first_gap), {}, {}, first_gap, d.residual_gap};
  m.motion = core_motion(m.problem.mesh, first_gap);
  m.layer = core_layer(m.problem.mesh, sizes, first_gap);
  return m;
}

}  // namespace

struct MagnetField::Impl {
  double residual;
  double gap;  ///< between the faces
  Problem problem;
  std::vector<double> motion, layer;
  Coenergy function;
  Newton newton;
  NewtonOptions options;

  Impl(Moving m, const NewtonOptions& o)
      : residual(m.residual),
        gap(m.gap),
        problem(std::move(m.problem)),
        motion(std::move(m.motion)),
        layer(std::move(m.layer)),
        function(problem),
        newton(function),
        options(o) {}

  /// Pull, positive when the gap closes, for a weight.
  double pull(const State& s, const std::vector<double>& weight) const {
    return -stress_force(function, s, weight)[2];
  }
};

MagnetField::MagnetField(const MagnetDesign& design, const CoreMeshSizes& sizes, const NewtonOptions& options)
    : MagnetField(moving_core(design, sizes), options) {}

MagnetField::MagnetField(Moving moving, const NewtonOptions& options)
    : impl_(std::make_unique<Impl>(std::move(moving), options)) {}

MagnetField::~MagnetField() = default;

int MagnetField::unknowns() const {
  return impl_->function.unknowns();
}

bool MagnetField::has_ring() const {
  return impl_->function.windings() == 2;
}

const Coenergy& MagnetField::function() const {
  return impl_->function;
}

void MagnetField::set_gap(double gap) {
  require("gap_mm", gap * 1e3, 0, 100);
  const double move = gap + impl_->residual - impl_->gap;
  if (move == 0) return;
  for (std::size_t n = 0; n < impl_->motion.size(); ++n)
    impl_->problem.mesh.nodes[n][2] += move * impl_->motion[n];
  impl_->gap += move;
  impl_->function.nodes_moved();
}

FieldPoint MagnetField::at_flux(double psi, double ring, const State& start, bool ring_open) {
  std::vector<Drive> drive{{true, psi}};
  if (has_ring()) drive.push_back({!ring_open, ring_open ? 0 : ring});
  return finish(impl_->newton.solve(drive, start, impl_->options), has_ring() && !ring_open);
}

FieldPoint MagnetField::at_current(double current, double ring_current, const State& start) {
  std::vector<Drive> drive{{false, current}};
  if (has_ring()) drive.push_back({false, ring_current});
  return finish(impl_->newton.solve(drive, start, impl_->options), has_ring() && ring_current != 0);
}

/// Second derivatives from the tangents.
FieldPoint MagnetField::finish(Solution solution, bool ring_bound) {
  FieldPoint p;
  const State& s = solution.state;
  const std::size_t m = s.current.size();
  std::vector<double> inductance;
  constexpr double near = 1e-9;  // decrement of a last step whose matrix is that of the solution
  auto tangents = impl_->newton.tangents(s, inductance, solution.converged && solution.decrement < near);
  p.psi = solution.flux[0];
  p.response.energy = solution.energy;
  p.response.current = s.current[0];
  if (m == 2) {
    p.ring = solution.flux[1];
    p.response.ring_current = s.current[1];
  }
  p.response.pull = impl_->pull(s, impl_->motion);
  p.stress_pull = impl_->pull(s, impl_->layer);
  std::vector<double> pull_by_current;
  for (std::size_t k = 0; k < m; ++k) {
    State t{tangents[k], std::vector<double>(m, 0)};
    t.current[k] = 1;
    pull_by_current.push_back(-stress_force_slope(impl_->function, s, t, impl_->motion)[2]);
  }
  if (m == 2 && ring_bound) {
    const double det = inductance[0] * inductance[3] - inductance[1] * inductance[2];
    p.response.current_psi = inductance[3] / det;
    p.response.current_ring = -inductance[1] / det;
    p.response.ring_ring = inductance[0] / det;
    p.response.current_gap =
        (pull_by_current[0] * p.response.current_psi + pull_by_current[1] * p.response.current_ring);
    p.response.ring_gap =
        (pull_by_current[0] * p.response.current_ring + pull_by_current[1] * p.response.ring_ring);
  } else {
    p.response.current_psi = 1 / inductance[0];
    p.response.current_gap = pull_by_current[0] / inductance[0];
  }
  p.tangents = std::move(tangents);
  p.solution = std::move(solution);
  return p;
}

}  // namespace powbench::sim::space
