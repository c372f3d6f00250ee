#include "sim/models/modal_closing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.h"
#include "sim/models/rigid_closing.h"
#include "sim/solid/modal_motion.h"
#include "sim/specimen/validate.h"

namespace powbench::sim {
namespace {

using Kind = PlantEvent::Kind;

void check(const Specimen& s, const ModalClosingOptions& o) {
  require_valid(s);
  const auto fail = [](const char* key, double value, const char* allowed) {
    throw std::invalid_argument(std::string(key) + " = " + std::to_string(value) + ", allowed " + allowed);
  };
  if (!(o.step >= 0.01 && o.step <= 0.9)) fail("step", o.step, "0.01 .. 0.9 of the critical one");
  if (!(o.damping >= 0 && o.damping <= 1)) fail("damping", o.damping, "0 .. 1");
  if (!(o.duration > 0 && o.duration <= 100)) fail("duration", o.duration, "0 .. 100 s");
  if (!(o.sample >= 0)) fail("sample", o.sample, "0 s and more");
  if (s.base.core_mass > 0)
    fail("base.core_mass_g", s.base.core_mass * 1e3,
         "0 on the modal rung: its static core is part of the base");
}

/// Bodies and coil, one step after the other.
class ModalRun {
 public:
  ModalRun(const Specimen& s, const Conditions& c, const MagneticPotential& potential,
           const ModalParts& modal, const ModalClosingOptions& o)
      : mains_(closing_mains(c)),
        potential_(potential),
        options_(o),
        body_(rigid_parts(s), modal, o.damping),
        off_(c.hold_time) {
    resistance_ =
        s.coil.resistance * (1 + s.coil.temperature_coefficient * (c.ambient - 293.15)) + mains_.resistance;
    ring_resistance_ = s.magnet.ring_resistance;
    u_ = body_.equilibrium();
    start_ = u_;
    v_.assign(u_.size(), 0.0);
    a_ = v_now_ = f_ = v_;
    // a whole number of steps between samples, and in the whole
    const double span = o.sample > 0 ? o.sample : o.duration;
    const double wanted = o.step * body_.critical_step();
    per_sample_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(span / wanted)));
    dt_ = span / static_cast<double>(per_sample_);
  }

  Trajectory run() {
    evaluate();
    const double at_rest = body_.stored(u_.data(), v_.data()) + response_.energy;
    const auto steps = static_cast<std::int64_t>(std::llrint(options_.duration / dt_));
    for (std::int64_t n = 1; n <= steps; ++n) {
      advance();
      time_ = static_cast<double>(n) * dt_;
      evaluate();
      if (n % 64 == 0 || n == steps) judge_energy(at_rest);
      if (options_.sample > 0 && n % per_sample_ == 0) result_.samples.push_back(sample());
    }
    result_.truth = closing_truth(result_.events, std::min(off_, options_.duration));
    for (const auto& s : result_.samples)
      result_.truth.peak_current = std::max(result_.truth.peak_current, std::fabs(s.coil_current));
    result_.evaluations = steps;
    return std::move(result_);
  }

 private:
  double voltage(double t) const { return mains_voltage(mains_, MainsPiece{}, t); }
  double gap() const {
    const double g = body_.separation(u_.data());
    return options_.pressed_gap ? g : std::max(0.0, g);
  }

  /// Field and forces at the state of now; events on the way here.
  void evaluate() {
    const Watched before = watched_;
    response_ = potential_.at({psi_, ring_, gap()});
    for (std::size_t k = 0; k < v_.size(); ++k) v_now_[k] = v_[k] + 0.5 * dt_ * a_[k];
    body_.forces(u_.data(), v_now_.data(), response_.pull, f_.data());
    const double speed = v_now_[ModalContactor::core];
    for (std::size_t k = 0; k < f_.size(); ++k) a_[k] = f_[k] / body_.mass(static_cast<int>(k));
    rub(speed);
    watched_ = {state(body_.pad(0)), state(body_.pad(1)), state(body_.pole())};
    if (time_ <= 0) return;
    publish(before.a, watched_.a, Kind::touch_a, Kind::release_a);
    publish(before.b, watched_.b, Kind::touch_b, Kind::release_b);
    publish(before.pole, watched_.pole, Kind::core_touch, Kind::core_release);
  }

  /// Coulomb friction of the core: it may stop the core within a step, not turn it round.
  void rub(double speed) {
    const double m = body_.mass(ModalContactor::core), limit = body_.friction() / m;
    double& a = a_[ModalContactor::core];
    const double next = v_[ModalContactor::core] + dt_ * a;
    const double taken = std::clamp(next, -dt_ * limit, dt_ * limit);
    a -= taken / dt_;
    friction_power_ = m * taken / dt_ * speed;
  }

  void advance() {
    const double half = 0.5 * dt_, t = time_ + half;
    if (open_) {
      hold_current_at_zero();
    } else {
      const auto& r = response_;
      const double u = voltage(time_), closing = v_now_[ModalContactor::core] - v_now_[ModalContactor::base];
      const double ring_rate = potential_.has_ring() ? -ring_resistance_ * r.ring_current : 0;
      const double psi_rate = u - resistance_ * r.current;
      const double current = r.current + half * (r.current_psi * psi_rate + r.current_ring * ring_rate -
                                                 r.current_gap * closing);
      const double ring_current = r.ring_current + half * (r.current_ring * psi_rate +
                                                           r.ring_ring * ring_rate - r.ring_gap * closing);
      psi_ += dt_ * (voltage(t) - resistance_ * current);
      if (potential_.has_ring()) ring_ -= dt_ * ring_resistance_ * ring_current;
      supplied_ += dt_ * voltage(t) * current;
      lost_ += dt_ * resistance_ * current * current;
      if (potential_.has_ring()) lost_ += dt_ * ring_resistance_ * ring_current * ring_current;
      open_ = time_ >= off_ && current * last_current_ <= 0 && last_current_ != 0;
      last_current_ = current;
    }
    lost_ += dt_ * (body_.loss(v_now_.data()) + friction_power_);
    for (std::size_t k = 0; k < u_.size(); ++k) {
      v_[k] += (time_ == 0 ? half : dt_) * a_[k];
      u_[k] += dt_ * v_[k];
    }
  }

  /// With the switch open the flux linkage follows the ring and the gap so that no current flows.
  void hold_current_at_zero() {
    if (potential_.has_ring()) {
      const double rate =
          response_.ring_ring - response_.current_ring * response_.current_ring / response_.current_psi;
      const double i = response_.ring_current;
      lost_ += dt_ * ring_resistance_ * i * i;
      ring_ -= dt_ * ring_resistance_ * i * (1 - 0.5 * dt_ * ring_resistance_ * rate);
    }
    for (int pass = 0; pass < 3; ++pass) {
      const auto r = potential_.at({psi_, ring_, gap()});
      psi_ -= r.current / r.current_psi;
    }
  }

  struct State {
    double depth = -1, pressing = -1, rate = 0;
    bool closed = false;
  };
  struct Watched {
    State a, b, pole;
  };
  static State state(const ModalContactor::Contact& c) {
    return {c.depth, c.stiffness * c.depth + c.damping * c.rate, c.rate, c.depth > 0 && c.force > 0};
  }

  void publish(const State& from, const State& to, Kind touch, Kind release) {
    if (from.closed == to.closed) return;
    const double a = to.closed ? from.depth : from.pressing,
                 b = to.closed ? to.depth : std::min(0.0, to.pressing);
    const double share = std::clamp(a == b ? 1.0 : a / (a - b), 0.0, 1.0);
    const double speed = to.closed ? (to.depth - from.depth) / dt_ : std::fabs(from.rate);
    result_.events.push_back({to.closed ? touch : release, time_ - dt_ * (1 - share), speed});
  }

  void judge_energy(double at_rest) {
    const double stored = body_.stored(u_.data(), v_now_.data()) + response_.energy;
    const double size = std::max(std::fabs(supplied_), 1e-3);
    result_.energy_residual =
        std::max(result_.energy_residual, std::fabs(stored - at_rest + lost_ - supplied_) / size);
  }

  PlantSample sample() const {
    PlantSample s;
    s.time = time_;
    s.mains_voltage = voltage(time_);
    s.coil_current = open_ ? 0 : response_.current;
    s.coil_voltage = open_ ? 0 : s.mains_voltage - mains_.resistance * s.coil_current;
    s.flux_linkage = psi_;
    s.pull = response_.pull;
    s.travel = u_[ModalContactor::core] - start_[ModalContactor::core];
    s.core_velocity = v_now_[ModalContactor::core];
    s.base = u_[ModalContactor::base];
    s.base_acceleration = a_[ModalContactor::base];
    s.core_force = body_.pole().force;
    s.force_a = body_.pad(0).force;
    s.force_b = body_.pad(1).force;
    return s;
  }

  Mains mains_;
  const MagneticPotential& potential_;
  ModalClosingOptions options_;
  ModalContactor body_;
  double off_;
  double resistance_ = 0, ring_resistance_ = 0;
  double time_ = 0, dt_ = 0;
  std::int64_t per_sample_ = 1;
  double psi_ = 0, ring_ = 0, last_current_ = 0;
  bool open_ = false;
  MagneticResponse response_;
  /// coordinates now; rates half a step back and now; accelerations; forces
  std::vector<double> u_, start_, v_, v_now_, a_, f_;
  Watched watched_;
  double supplied_ = 0, lost_ = 0, friction_power_ = 0;
  Trajectory result_;
};

}  // namespace

Trajectory modal_closing(const Specimen& specimen, const Conditions& conditions,
                         const MagneticPotential& potential, const ModalParts& parts,
                         const ModalClosingOptions& options) {
  check(specimen, options);
  ModalRun run(specimen, conditions, potential, parts, options);
  return run.run();
}

}  // namespace powbench::sim
