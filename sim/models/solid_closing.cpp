#include "sim/models/solid_closing.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "sim/models/closing.h"
#include "sim/solid/contactor_contacts.h"

namespace powbench::sim {
namespace {

constexpr double chatter = 20e-6;  ///< s, of deforming parts: shorter gaps between touches are not openings
constexpr double slip = 1e-11;     ///< m, deflection of the mover's guide before it slides

/// The bodies with their springs, and the coil beside them.
class SolidRun {
 public:
  SolidRun(const Specimen& specimen, const Conditions& conditions, const MagneticPotential& field,
           const SolidClosingOptions& options)
      : specimen_(specimen),
        field_(field),
        options_(options),
        mains_(closing_mains(conditions)),
        resistance_(specimen.coil.resistance *
                    (1 + specimen.coil.temperature_coefficient * (conditions.ambient - 293.15))),
        contactor_(contactor_mesh(specimen, options.cell)),
        solid_(contactor_.mesh, contactor_.materials, solid_options(options)) {
    const ContactorContacts meets = contactor_contacts(contactor_, solid_.cells(), specimen);
    stop_pair_ = meets.stop;
    start_ = -meets.seat_depth;
    solid_.set_contact(meets.options);
    solid_.add_plane(meets.rest);
    for (int n = solid_.cells().nodes_begin(contactor_.mover); n < solid_.cells().nodes_end(contactor_.mover);
         ++n)
      solid_.set_node_displacement(n, {0, 0, start_});
    add_springs();
    pull_ = solid_.add_load({solid_.whole_part(contactor_.mover), {}});
    reaction_ = solid_.add_load({solid_.whole_part(contactor_.base), {}});
    gap_ = specimen.core.travel;
    set_rigid(true);
  }

  SolidClosingResult run(const std::function<void(const ExplicitSolid&, const ContactorMesh&)>& watch) {
    result_.cells = static_cast<long>(contactor_.mesh.cells.size());
    result_.scaled_cells = solid_.added_inertia().cells();
    result_.added_inertia = solid_.added_inertia().share();
    solid_.step();
    solid_.set_step(options_.flight_step);
    double next_sample = 0, next_field = 0;
    while (solid_.time() < options_.end) {
      if (solid_.time() >= next_field) {
        couple(solid_.time() - coupled_);
        coupled_ = solid_.time();
        next_field = coupled_ + options_.coupling;
      }
      try {
        solid_.step();
      } catch (const SolidStop&) {
        if (watch) watch(solid_, contactor_);
        throw;
      }
      ++(rigid_ ? result_.rigid_steps : result_.deformed_steps);
      follow_contacts();
      if (rigid_ && options_.deform && close_to_touch()) wake();
      if (solid_.time() < next_sample) continue;
      next_sample = solid_.time() + (rigid_ ? 50e-6 : options_.sample);
      sample();
      if (watch) watch(solid_, contactor_);
    }
    result_.energies = solid_.energies();
    return result_;
  }

 private:
  static SolidOptions solid_options(const SolidClosingOptions& options) {
    SolidOptions o = options.solid;
    o.workers = options.workers;
    return o;
  }

  void add_springs() {
    SolidSpring back;
    back.a = solid_.whole_part(contactor_.mover);
    back.preload = specimen_.core.return_preload - specimen_.core.return_rate * start_;
    back.rate = specimen_.core.return_rate;
    solid_.add_spring(back);
    const double round = 2 * pi * specimen_.base.hertz;
    SolidSpring mounting;
    mounting.a = solid_.whole_part(contactor_.base);
    mounting.rate = specimen_.base.mass * round * round;
    solid_.add_spring(mounting);
    for (const int bridge : contactor_.bridges) {
      SolidSpring overtravel;  // the mover pushes the bridge ahead: the force grows as the mover overtakes it
      overtravel.a = solid_.whole_part(contactor_.mover);
      overtravel.b = solid_.whole_part(bridge);
      overtravel.preload = specimen_.bridges.preload - specimen_.bridges.rate * start_;
      overtravel.rate = specimen_.bridges.rate;
      solid_.add_spring(overtravel);
    }
  }

  void set_rigid(bool rigid) {
    rigid_ = rigid;
    for (int p = 0; p < static_cast<int>(contactor_.mesh.parts.size()); ++p) solid_.set_rigid(p, rigid);
  }

  void wake() {
    set_rigid(false);
    solid_.set_step(0.9 * solid_.step_limit());
  }

  double height(int part) const {
    return solid_.mean_displacement(part).z - (part == contactor_.mover ? start_ : 0);
  }

  /// The rung's answer; one that ends at gap zero goes on along its tangent where the faces are pressed together.
  MagneticResponse field(const MagneticState& s) const {
    if (options_.pressed_gap || s.gap >= 0) return field_.at(s);
    auto m = field_.at({s.psi, s.ring, 0});
    m.energy += s.gap * m.pull;
    m.current += s.gap * m.current_gap;
    m.ring_current += s.gap * m.ring_gap;
    return m;
  }

  /// Field and coil over the time since the latest look, by the midpoint rule; then the new pull.
  void couple(double dt) {
    const double gap = specimen_.core.travel - height(contactor_.mover) + height(contactor_.base);
    const double voltage = mains_voltage(mains_, MainsPiece{}, solid_.time() - 0.5 * dt);
    const auto at = [&](double share, const MagneticResponse& r) {
      const double ring = field_.has_ring() ? specimen_.magnet.ring_resistance * r.ring_current : 0;
      return field({psi_ + share * dt * (voltage - resistance_ * r.current), ring_ - share * dt * ring,
                    gap_ + share * (gap - gap_)});
    };
    const MagneticResponse middle = at(0.5, response_);
    const double lost = resistance_ * middle.current * middle.current,
                 ring = field_.has_ring() ? specimen_.magnet.ring_resistance * middle.ring_current : 0;
    result_.electric.supplied += dt * voltage * middle.current;
    result_.electric.lost += dt * (lost + ring * middle.ring_current);
    result_.electric.pull_work += middle.pull * (gap_ - gap);
    psi_ += dt * (voltage - resistance_ * middle.current);
    ring_ -= dt * ring;
    gap_ = gap;
    const double before = response_.pull;
    response_ = field({psi_, ring_, gap});
    result_.electric.field = response_.energy;
    // held over the next interval: what it will be in its middle
    push(dt,
         dt > 0 ? response_.pull + 0.5 * (response_.pull - before) * options_.coupling / dt : response_.pull);
  }

  /// Return map: a spring that slides at the Coulomb limit, with a dashpot of half the critical damping beside it;
  /// softer where the coupling interval is too long for so stiff a spring.
  double friction(double dt) {
    const double limit = specimen_.core.friction, fastest = 0.3 / options_.coupling;
    const double rate = std::min(limit / slip, specimen_.core.mass * fastest * fastest);
    const double speed = solid_.mean_velocity(contactor_.mover).z;
    stuck_ = std::clamp(stuck_ + rate * speed * dt, -limit, limit);
    return std::clamp(stuck_ + std::sqrt(rate * specimen_.core.mass) * speed, -limit, limit);
  }

  /// Pull, friction and drag as body loads.
  void push(double dt, double pull) {
    solid_.set_force(pull_, {0, 0, pull - friction(dt)});
    const double drag = 4 * pi * specimen_.base.hertz * specimen_.base.damping * specimen_.base.mass;
    solid_.set_force(reaction_, {0, 0, -pull - drag * solid_.mean_velocity(contactor_.base).z});
  }

  bool close_to_touch() const {
    const double speed = solid_.mean_velocity(contactor_.bridges[0]).z;
    const double left = specimen_.bridges.gap - height(contactor_.bridges[0]) + height(contactor_.base);
    return speed > 0.05 && left < speed * options_.window;
  }

  void follow_contacts() {
    const ContactReport& pad = solid_.contact()->report(0);
    const bool closed = pad.force_sum > 0;  // a dent that is left behind presses no more
    if (closed && result_.first_touch < 0) result_.first_touch = solid_.time();
    const double shortest = options_.deform ? chatter : 4 * solid_.dt();  // nodes come and go within a touch
    if (closed && solid_.time() - closed_at_ > shortest) {
      result_.last_touch = solid_.time();
      if (closed_at_ > 0) {
        ++result_.openings;
        result_.open.push_back({closed_at_, solid_.time()});
      }
    }
    if (closed) closed_at_ = solid_.time();
    result_.peak_force = std::max(result_.peak_force, pad.force_sum);
    if (result_.core_seat < 0 && solid_.contact()->report(stop_pair_).touching > 0)
      result_.core_seat = solid_.time();
    const SolidEnergies& e = solid_.energies();
    const double size = std::max({e.stored(), std::fabs(e.external), 1e-6});
    result_.residual = std::max(result_.residual, std::fabs(e.residual()) / size);
  }

  void sample() {
    SolidClosingSample s;
    s.time = solid_.time();
    s.current = response_.current;
    s.flux = psi_;
    s.pull = response_.pull;
    s.travel = height(contactor_.mover);
    s.base = height(contactor_.base);
    s.pad_force = solid_.contact()->report(0).force_sum;
    for (const int bridge : contactor_.bridges) s.bridges.push_back(height(bridge));
    result_.samples.push_back(s);
  }

  Specimen specimen_;
  const MagneticPotential& field_;
  SolidClosingOptions options_;
  Mains mains_;
  double resistance_;  // ohm, warm
  ContactorMesh contactor_;
  ExplicitSolid solid_;
  SolidClosingResult result_;
  MagneticResponse response_;
  int pull_ = 0, reaction_ = 0, stop_pair_ = 0;
  double psi_ = 0, ring_ = 0, gap_ = 0, coupled_ = 0;
  double stuck_ = 0;  // N, friction of the mover's guide in its spring
  double start_ = 0;  // m, of the mover: lowered by the deflection of the seats
  double closed_at_ = -1;
  bool rigid_ = true;
};

}  // namespace

SolidClosingResult solid_closing(
    const Specimen& specimen, const Conditions& conditions, const MagneticPotential& field,
    const SolidClosingOptions& options,
    const std::function<void(const ExplicitSolid&, const ContactorMesh&)>& watch) {
  if (!(options.end > 0))
    throw std::invalid_argument("end = " + std::to_string(options.end) + " s, must be > 0");
  if (!(options.coupling > 0 && options.coupling <= 1e-4))
    throw std::invalid_argument("coupling = " + std::to_string(options.coupling) +
                                " s, must be in (0, 1e-4]");
  SolidRun closing(specimen, conditions, field, options);
  return closing.run(watch);
}

}  // namespace powbench::sim
