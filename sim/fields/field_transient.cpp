#include "sim/fields/field_transient.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace powbench::sim {
namespace {

/// What a rung answers at the middle of a step.
struct Middle {
  double psi = 0;  ///< coil, at the middle
  double current = 0, ring_current = 0, pull = 0, eddy_power = 0;
};

/// The mechanics and the ledger, common to all rungs. `solve(voltage, gap, step)` advances the fluxes by one step.
template <class Rung>
TransientResult march(Rung& rung, const TransientSetup& s) {
  if (!(s.step > 0 && s.duration > 0 && s.mass > 0 && s.resistance >= 0 && s.start_gap >= 0 && s.voltage))
    throw std::invalid_argument(
        "transient: step, duration and mass must be above 0, resistance and gap not below, a voltage is "
        "needed");
  TransientResult out;
  const int steps = static_cast<int>(std::lround(s.duration / s.step));
  double gap = s.start_gap, velocity = 0, psi = 0;
  const double before = rung.stored(gap);
  auto& e = out.energy;
  for (int k = 0; k < steps; ++k) {
    const double middle_time = (k + 0.5) * s.step;
    const double voltage = s.voltage(middle_time);
    const double middle_gap = s.moves ? std::clamp(gap - 0.5 * s.step * velocity, 0.0, s.start_gap) : gap;
    const Middle m = rung.advance(voltage, middle_gap, s.step);
    psi = 2 * m.psi - psi;
    const double old_gap = gap, old_velocity = velocity;
    if (s.moves) {
      const double counter = s.counter_force ? s.counter_force(middle_gap) : 0;
      velocity += s.step * (m.pull - counter) / s.mass;
      gap -= 0.5 * s.step * (old_velocity + velocity);
      if (gap <= 0 || gap >= s.start_gap) {
        if (gap <= 0 && out.closed_at < 0) {
          const double way = old_gap - gap;
          out.closed_at = (k + (way > 0 ? old_gap / way : 0)) * s.step;
        }
        gap = std::clamp(gap, 0.0, s.start_gap);
        velocity = 0;
      }
    }
    e.supplied += s.step * voltage * m.current;
    e.coil_loss += s.step * s.resistance * m.current * m.current;
    e.ring_loss += s.step * s.ring_resistance * m.ring_current * m.ring_current;
    e.eddy_loss += s.step * m.eddy_power;
    e.mechanical += m.pull * (old_gap - gap);
    out.samples.push_back({(k + 1) * s.step, psi, m.current, m.ring_current, gap, velocity, m.pull});
  }
  e.stored = rung.stored(gap) - before;
  out.iterations = rung.iterations;
  return out;
}

class FieldRung {
 public:
  FieldRung(const MagnetDesign& d, const FieldOptions& o, const TransientSetup& s)
      : design_(d),
        setup_(s),
        options_(o),
        problem_(magnet_problem(d, o, s.iron_conductivity)),
        newton_(problem_) {
    const auto size = static_cast<std::size_t>(problem_.size()) + 1;
    a_.assign(size, 0);
    load_.assign(size, 0);
    fluxes_.assign(problem_.setup().windings.size(), 0);
  }

  int iterations = 0;

  double stored(double gap) {
    problem_.set_gap(gap + design_.residual_gap);
    std::vector<double> gradient(a_.size(), 0);
    multiply(problem_.space().pattern, problem_.linear(), a_.data(), gradient.data());
    gradient.back() = 0;
    const double linear = 0.5 * dot(a_, gradient);
    const double leaked = design_.end_leakage > 0 ? (fluxes_[0] - dot(problem_.winding(0), a_)) : 0;
    return linear + problem_.add_steel(a_.data(), gradient.data(), nullptr) +
           (leaked != 0 ? 0.5 * leaked * leaked / design_.end_leakage : 0);
  }

  Middle advance(double voltage, double gap, double step) {
    problem_.set_gap(gap + design_.residual_gap);
    const bool eddies = !problem_.mass().empty();
    if (eddies) {
      matrix_ = problem_.linear();
      for (std::size_t k = 0; k < matrix_.size(); ++k) matrix_[k] += 2 / step * problem_.mass()[k];
      multiply(problem_.space().pattern, problem_.mass(), a_.data(), load_.data());
      for (double& value : load_) value *= 2 / step;
      load_.back() = 0;
      newton_.set_quadratic(&matrix_, &load_);
    }
    std::vector<Circuit> circuits{
        {true, fluxes_[0] + 0.5 * step * voltage, design_.end_leakage + 0.5 * step * setup_.resistance}};
    if (fluxes_.size() > 1) circuits.push_back({true, fluxes_[1], 0.5 * step * setup_.ring_resistance});
    std::vector<double> middle = a_;
    const auto report = newton_.solve(circuits, middle, current_, options_.newton);
    if (!report.converged) throw std::runtime_error("transient: the field does not converge");
    iterations += report.iterations;
    Middle m;
    m.current = current_[0];
    if (fluxes_.size() > 1) m.ring_current = current_[1];
    m.psi = fluxes_[0] + 0.5 * step * (voltage - setup_.resistance * m.current);
    std::vector<double> slope(a_.size());
    problem_.gap_gradient(middle.data(), slope.data());
    m.pull = 0.5 * dot(middle, slope);
    for (std::size_t k = 0; k < a_.size(); ++k) slope[k] = 2 * (middle[k] - a_[k]);  // the whole step
    if (eddies) {
      multiply(problem_.space().pattern, problem_.mass(), slope.data(), load_.data());
      load_.back() = 0;
      m.eddy_power = dot(slope, load_) / (step * step);
    }
    for (std::size_t k = 0; k < a_.size(); ++k) a_[k] += slope[k];
    fluxes_[0] += step * (voltage - setup_.resistance * m.current);
    if (fluxes_.size() > 1) fluxes_[1] -= step * setup_.ring_resistance * m.ring_current;
    return m;
  }

 private:
  static double dot(const std::vector<double>& x, const std::vector<double>& y) {
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k) sum += x[k] * y[k];
    return sum;
  }

  MagnetDesign design_;
  TransientSetup setup_;
  FieldOptions options_;
  FieldProblem problem_;
  Newton newton_;
  std::vector<double> a_, load_, matrix_, fluxes_, current_;
};

class PotentialRung {
 public:
  PotentialRung(const MagneticPotential& p, const TransientSetup& s) : potential_(p), setup_(s) {}

  int iterations = 0;

  double stored(double gap) const { return potential_.at({psi_, ring_, gap}).energy; }

  /// Newton on the two fluxes at the middle of the step.
  Middle advance(double voltage, double gap, double step) {
    constexpr int most = 50;
    const double h = 0.5 * step, r = setup_.resistance,
                 q = potential_.has_ring() ? setup_.ring_resistance : 0;
    double psi = psi_, ring = ring_;
    MagneticResponse m;
    for (int k = 0; k < most; ++k) {
      m = potential_.at({psi, ring, gap});
      ++iterations;
      const double f = psi - psi_ - h * (voltage - r * m.current), g = ring - ring_ + h * q * m.ring_current;
      const double a = 1 + h * r * m.current_psi, b = h * r * m.current_ring, c = h * q * m.current_ring,
                   d = 1 + h * q * m.ring_ring;
      const double det = a * d - b * c;
      const double dpsi = (f * d - b * g) / det, dring = (a * g - c * f) / det;
      psi -= dpsi;
      ring -= dring;
      if (std::fabs(dpsi) < 1e-13 * (1 + std::fabs(psi)) && std::fabs(dring) < 1e-16) break;
    }
    m = potential_.at({psi, ring, gap});
    psi_ = 2 * psi - psi_;
    ring_ = 2 * ring - ring_;
    return {psi, m.current, m.ring_current, m.pull, 0};
  }

 private:
  const MagneticPotential& potential_;
  TransientSetup setup_;
  double psi_ = 0, ring_ = 0;
};

}  // namespace

double TransientEnergy::residual() const {
  return (supplied - coil_loss - ring_loss - eddy_loss - mechanical - stored) / supplied;
}

TransientResult run_transient(const MagnetDesign& d, const FieldOptions& o, const TransientSetup& s) {
  FieldRung rung(d, o, s);
  return march(rung, s);
}

TransientResult run_transient(const MagneticPotential& p, const TransientSetup& s) {
  PotentialRung rung(p, s);
  return march(rung, s);
}

}  // namespace powbench::sim
