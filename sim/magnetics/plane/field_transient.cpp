#include "sim/magnetics/plane/field_transient.h"

#include <cmath>
#include <stdexcept>

#include "sim/magnetics/plane/transient_march.h"

namespace powbench::sim {
namespace {

/// The resistance beside the coil's flux: dpsi/dt = u - R (dW/dpsi + dpsi/dt / R_e).
struct Sheets {
  double share = 1, conductance = 0;
  explicit Sheets(const TransientSetup& s) {
    if (!(s.sheet_resistance >= 0)) throw std::invalid_argument("transient: sheet_resistance below 0 ohm");
    if (s.sheet_resistance == 0) return;
    conductance = 1 / s.sheet_resistance;
    share = 1 / (1 + s.resistance * conductance);
  }
  double current(double rate) const { return rate * conductance; }
};

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
    const auto leaked = [&](double leakage, std::size_t winding) {  // energy of an inductance in series
      const double flux = leakage > 0 ? fluxes_[winding] - dot(problem_.winding(winding), a_) : 0;
      return flux != 0 ? 0.5 * flux * flux / leakage : 0;
    };
    return linear + problem_.add_steel(a_.data(), gradient.data(), nullptr) + leaked(design_.end_leakage, 0) +
           (fluxes_.size() > 1 ? leaked(design_.ring_leakage, 1) : 0);
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
    const Sheets sheets(setup_);
    const double r = setup_.resistance;
    std::vector<Circuit> circuits{{true, fluxes_[0] + 0.5 * step * sheets.share * voltage,
                                   design_.end_leakage + 0.5 * step * sheets.share * r}};
    if (fluxes_.size() > 1)
      circuits.push_back({true, fluxes_[1], design_.ring_leakage + 0.5 * step * setup_.ring_resistance});
    std::vector<double> middle = a_;
    const auto report = newton_.solve(circuits, middle, current_, options_.newton);
    if (!report.converged) throw std::runtime_error("transient: the field does not converge");
    iterations += report.iterations;
    Middle m;
    const double rate = sheets.share * (voltage - r * current_[0]);
    m.current = current_[0] + sheets.current(rate);
    if (fluxes_.size() > 1) m.ring_current = current_[1];
    m.psi = fluxes_[0] + 0.5 * step * rate;
    m.eddy_power = sheets.current(rate) * rate;
    m.pull = problem_.gap_slope(middle.data());
    std::vector<double> slope(a_.size());
    for (std::size_t k = 0; k < a_.size(); ++k) slope[k] = 2 * (middle[k] - a_[k]);  // the whole step
    if (eddies) {
      multiply(problem_.space().pattern, problem_.mass(), slope.data(), load_.data());
      load_.back() = 0;
      m.eddy_power += dot(slope, load_) / (step * step);
    }
    for (std::size_t k = 0; k < a_.size(); ++k) a_[k] += slope[k];
    fluxes_[0] += step * rate;
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
    const Sheets sheets(setup_);
    const double h = 0.5 * step * sheets.share, half = 0.5 * step, r = setup_.resistance,
                 q = potential_.has_ring() ? setup_.ring_resistance : 0;
    double psi = psi_, ring = ring_;
    MagneticResponse m;
    for (int k = 0; k < most; ++k) {
      m = potential_.at({psi, ring, gap});
      ++iterations;
      const double f = psi - psi_ - h * (voltage - r * m.current),
                   g = ring - ring_ + half * q * m.ring_current;
      const double a = 1 + h * r * m.current_psi, b = h * r * m.current_ring, c = half * q * m.current_ring,
                   d = 1 + half * q * m.ring_ring;
      const double det = a * d - b * c;
      const double dpsi = (f * d - b * g) / det, dring = (a * g - c * f) / det;
      psi -= dpsi;
      ring -= dring;
      if (std::fabs(dpsi) < 1e-13 * (1 + std::fabs(psi)) && std::fabs(dring) < 1e-16) break;
    }
    m = potential_.at({psi, ring, gap});
    psi_ = 2 * psi - psi_;
    ring_ = 2 * ring - ring_;
    const double rate = sheets.share * (voltage - r * m.current), eddy = sheets.current(rate);
    return {psi, m.current + eddy, m.ring_current, m.pull, eddy * rate};
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
