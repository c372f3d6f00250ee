#include <cstdio>

#include "core/random.h"
#include "core/units.h"
#include "sim/magnetics/plane/solenoid_field.h"
#include "sim/magnetics/plane/table_sweep.h"
#include "sim/magnetics/plane/transient_march.h"

namespace powbench::sim {
namespace {

class SolenoidRung {
 public:
  SolenoidRung(const SolenoidDesign& d, const FieldOptions& o, const TransientSetup& s)
      : resistance_(s.resistance),
        field_(d, o, s.iron_conductivity),
        eddies_(s.iron_conductivity > 0),
        a_(static_cast<std::size_t>(field_.unknowns()) + 1, 0) {
    field_.set_gap(s.start_gap);
    gap_ = s.start_gap;
    if (d.remanence == 0) return;
    const auto p = field_.at_current(0);
    psi_ = field_.flux(p);
    a_ = p.a;
  }

  int iterations = 0;

  double flux() const { return psi_; }

  double stored(double gap) {
    constexpr double instant = 1e-12;  // s: eddy currents keep the flux in the iron, the air follows
    carry_to(gap);
    // without them the state is the flux: the field of the middle of the last step is but a start
    return field_.energy((eddies_ ? field_.eddy_step(psi_, 0, instant, a_) : field_.at_flux(psi_, a_)).a);
  }

  Middle advance(double voltage, double gap, double step) {
    carry_to(gap);
    const double b = psi_ + 0.5 * step * voltage, r = 0.5 * step * resistance_;
    auto p = eddies_ ? field_.eddy_step(b, r, step, a_) : field_.in_circuit(b, r, std::move(a_));
    if (!p.newton.converged) throw std::runtime_error("transient: the field does not converge");
    iterations += p.newton.iterations;
    const double rate = voltage - resistance_ * p.response.current;
    Middle m{psi_ + 0.5 * step * rate, p.response.current, 0, p.response.pull, 0};
    psi_ += step * rate;
    if (!eddies_) {
      a_ = std::move(p.a);
      return m;
    }
    std::vector<double> slope(a_.size());
    for (std::size_t k = 0; k < a_.size(); ++k) {
      slope[k] = 2 * (p.a[k] - a_[k]) / step;
      a_[k] = 2 * p.a[k] - a_[k];
    }
    m.eddy_power = field_.eddy_power(slope);
    return m;
  }

 private:
  void carry_to(double gap) {
    const double before = gap_;
    field_.set_gap(gap);
    gap_ = gap;
    if (eddies_) a_ = field_.carry(a_, before);
  }

  double resistance_;
  SolenoidField field_;
  bool eddies_;
  std::vector<double> a_;
  double psi_ = 0, gap_ = 0;
};

}  // namespace

std::uint64_t table_hash(const SolenoidDesign& d, const TableOptions& o) {
  const auto& s = d.shape;
  std::vector<double> values{s.plunger_radius,
                             s.bore_radius,
                             s.plunger_length,
                             s.stop_length,
                             s.window,
                             s.plate,
                             s.flange,
                             s.coil_inner,
                             s.coil_outer,
                             s.coil_clearance,
                             s.case_inner,
                             s.case_outer,
                             static_cast<double>(s.face),
                             s.cone_angle,
                             s.tip_radius,
                             s.step_radius,
                             s.step_depth,
                             s.step_clearance,
                             s.magnet_length,
                             d.magnet_permeability,
                             d.turns,
                             d.residual_gap,
                             d.largest_gap,
                             o.accuracy,
                             o.largest_field,
                             static_cast<double>(o.psi_nodes),
                             static_cast<double>(o.gap_nodes)};
  return hash_values(values, d.steel);
}

PotentialTable build_table(const SolenoidDesign& d, const TableOptions& o, Team& team, TableReport* report) {
  if (d.remanence != 0)
    throw std::invalid_argument("solenoid.remanence_T: a table needs 0, its energy is even in the flux");
  auto options = o;
  options.largest_gap = d.largest_gap;
  const double radius = d.shape.plunger_radius;
  const TablePlan plan = plan_table(options, d.turns * pi * radius * radius * o.largest_field);
  TableReport sum;
  auto t =
      fill_table(plan, false, team, SolenoidGap(d, plan.field, 0), newton_of_table(o.accuracy, false), &sum);
  estimate_errors(t);
  t.mesh_error = plan.mesh_error;
  t.data_end = d.steel.data_end();
  t.design_hash = table_hash(d, options);
  char text[160];
  std::snprintf(text, sizeof text, "solenoid, %zu x %zu nodes, %d unknowns, %s, %g turns, residual gap %g um",
                t.psi.size(), t.gap.size(), sum.unknowns, d.steel.name().c_str(), d.turns,
                d.residual_gap * 1e6);
  t.description = text;
  if (report) *report = sum;
  return t;
}

TransientResult run_transient(const SolenoidDesign& d, const FieldOptions& o, const TransientSetup& s) {
  if (s.sheet_resistance != 0)
    throw std::invalid_argument("transient: sheet_resistance of a solenoid must be 0, its parts are solid");
  if (!(s.iron_conductivity >= 0 && s.iron_conductivity <= 1e8))
    throw std::invalid_argument("transient: iron_conductivity = " + std::to_string(s.iron_conductivity) +
                                " S/m, allowed 0 .. 1e8");
  if (s.start_gap > d.largest_gap)
    throw std::invalid_argument("transient: start_gap_mm = " + std::to_string(s.start_gap * 1e3) +
                                ", allowed 0 .. " + std::to_string(d.largest_gap * 1e3));
  SolenoidRung rung(d, o, s);
  return march(rung, s);
}

}  // namespace powbench::sim
