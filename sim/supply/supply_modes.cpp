#include "sim/supply/supply_modes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/supply/refuse.h"

namespace powbench::sim {

void require_valid(const CoilSwitch& s) {
  require_range("switch closing_delay", s.closing_delay, 0, 10, "s");
  require_range("switch opening_delay", s.opening_delay, 0, 10, "s");
  double touched = 0;
  for (const auto& b : s.bounces) {
    if (b.open == 0 && b.close == 0) continue;
    require_range("switch bounce open", b.open, touched, 1, "s, after the bounce before");
    require_range("switch bounce close", b.close, b.open, 1, "s, after its opening");
    touched = b.close;
  }
  require_range("switch latching_current", s.latching_current, 0, 1e3, "A");
  require_range("switch holding_current", s.holding_current, 0, s.latching_current,
                "A, the latching current");
  require_range("switch gate_pulse", s.gate_pulse, 0, 1e3, "s");
  require_range("switch gate_period", s.gate_period, 0, 1e3, "s");
  require_range("switch hold_period", s.hold_period, 0, 1, "s");
  require_range("switch hold_after", s.hold_after, 0, 1e3, "s");
  require_range("switch hold_duty", s.hold_duty, 0.01, 0.99, "");
  if (s.gate_period > 0)
    require_range("switch gate_period", s.gate_period, s.gate_pulse, 1e3, "s, from the gate_pulse");
}

void require_valid(const Suppression& s) {
  const bool rc = s.kind == Suppression::Kind::rc;
  require_range("suppression forward", s.forward, 0.1, 20, "V");
  require_range("suppression resistance", s.resistance, rc ? 0.1 : 0, 1e6, rc ? "ohm for rc" : "ohm");
  require_range("suppression capacitance", s.capacitance, 1e-12, 1, "F");
  require_range("suppression clamp", s.clamp, 1, 1e5, "V");
  require_range("suppression clamp_current", s.clamp_current, 1e-6, 1e4, "A");
  require_range("suppression clamp_exponent", s.clamp_exponent, 0, 1, "");
}

void require_valid(const Supply& s) {
  require_valid(s.mains);
  require_valid(s.coil_switch);
  require_valid(s.suppression);
  const std::string what = unsuited(s);
  if (!what.empty()) throw std::invalid_argument(what);
}

std::string unsuited(const Supply& s) {
  using Kind = Suppression::Kind;
  const bool ac = s.mains.kind == Mains::Kind::ac, dc = s.mains.kind == Mains::Kind::dc;
  const auto& p = s.suppression;
  if (p.kind == Kind::diode && ac)
    return "suppression.kind = diode: shorts every second half-wave of alternating mains; allowed with "
           "supply.kind = dc, "
           "half_wave, full_wave";
  if (p.kind != Kind::none && s.mains.inductance > 0)
    return "suppression.kind: with supply.inductance_mH above 0 the source's own energy has no path; allowed "
           "none";
  if (p.kind == Kind::rc && !dc) return "suppression.kind = rc: modelled with supply.kind = dc only";
  if (p.kind == Kind::diode && p.resistance != 0 && !dc)
    return "suppression.resistance_ohm: allowed 0 for a diode behind a rectifier, where both conduct at once";
  if (s.coil_switch.kind == CoilSwitch::Kind::triac && !ac)
    return "switch.kind = triac: never turns off without a zero of the current; allowed with supply.kind = "
           "ac";
  if (s.coil_switch.hold_period == 0) return "";
  if (s.coil_switch.kind != CoilSwitch::Kind::ideal)
    return "switch.hold_period_us: an economiser is an ideal switch; allowed with switch.kind = ideal";
  if (ac || p.kind == Kind::none)
    return "switch.hold_period_us: an economiser chops a direct or rectified voltage and its coil needs a "
           "suppression; "
           "allowed with supply.kind = dc, half_wave, full_wave and suppression.kind = diode, varistor, rc";
  return "";
}

SupplyModes::SupplyModes(const Supply& supply) : supply_(supply) {
  require_valid(supply);
  if (supply.coil_switch.kind != CoilSwitch::Kind::triac) return;
  latching_ = supply.coil_switch.latching_current;
  holding_ = supply.coil_switch.holding_current;
}

/// The changes of the switch that follow a command, or the first edge of a gate pulse.
void SupplyModes::schedule(double t) {
  const auto& s = supply_.coil_switch;
  due_.clear();
  switch (s.kind) {
    case CoilSwitch::Kind::ideal:
      due_.push_back({t, commanded_ ? Act::close : Act::part});
      if (!commanded_ || s.hold_period == 0) break;
      due_.push_back({t + s.hold_after, Act::part});
      due_.push_back({t + s.hold_after + (1 - s.hold_duty) * s.hold_period, Act::close});
      break;
    case CoilSwitch::Kind::relay: {
      const double touch = t + (commanded_ ? s.closing_delay : s.opening_delay);
      due_.push_back({touch, commanded_ ? Act::close : Act::part});
      if (!commanded_) break;
      for (const auto& b : s.bounces) {
        if (!(b.close > b.open)) continue;
        due_.push_back({touch + b.open, Act::part});
        due_.push_back({touch + b.close, Act::close});
      }
      break;
    }
    case CoilSwitch::Kind::triac:
      due_.push_back({t, commanded_ ? Act::close : Act::part});
      if (!commanded_ || s.gate_pulse == 0) break;
      due_.push_back({t + s.gate_pulse, Act::part});
      if (s.gate_period > 0) due_.push_back({t + s.gate_period, Act::close});
      break;
  }
}

SupplyModes::Effect SupplyModes::command(double t, bool on, double current) {
  if (on == commanded_) return Effect::none;
  commanded_ = on;
  if (on && t < origin_) origin_ = t;
  piece_ = mains_piece(supply_.mains, t, origin_);
  schedule(t);
  return due_.front().time <= t ? pass(t, current) : Effect::none;
}

SupplyModes::Effect SupplyModes::pass(double t, double current) {
  Effect effect = Effect::none;
  if (!std::isfinite(next_change())) return effect;
  t = std::max(t, next_change());  // whoever locates the event may land a rounding error before it
  while (!due_.empty() && due_.front().time <= t) {
    const Change change = due_.front();
    const auto& s = supply_.coil_switch;
    const bool last_close = due_.size() == 1 && change.act == Act::close && commanded_;
    if (last_close && s.gate_period > 0 && s.kind == CoilSwitch::Kind::triac) schedule(change.time);
    due_.erase(due_.begin());
    if (last_close && s.hold_period > 0 && s.kind == CoilSwitch::Kind::ideal) {
      due_.push_back({change.time + s.hold_duty * s.hold_period, Act::part});
      due_.push_back({change.time + s.hold_period, Act::close});
    }
    if (change.act == Act::close) {
      close(current);
      continue;
    }
    const Effect parted = part(current);
    if (parted == Effect::none) continue;
    effect = parted;
    current = 0;
  }
  piece_ = mains_piece(supply_.mains, t, origin_);
  choose_path(t, current);
  return effect;
}

void SupplyModes::close(double current) {
  if (coil_ == Coil::open) latched_ = std::fabs(current) >= latching_;
  coil_ = Coil::closed;
  if (!rectifies()) path_ = Path::source;  // else choose_path() decides
}

SupplyModes::Effect SupplyModes::part(double current) {
  if (coil_ != Coil::closed) return Effect::none;
  const double size = std::fabs(current);
  const bool stays = alternates() && size > holding_ && (latched_ || size >= latching_);
  coil_ = stays ? Coil::opening : Coil::open;
  sign_ = current > 0 ? 1 : -1;
  if (stays || path_ == Path::suppression) return Effect::none;
  return leave_source(current);
}

/// The source is cut off: the suppression takes the current if it can.
SupplyModes::Effect SupplyModes::leave_source(double current) {
  using Kind = Suppression::Kind;
  const Kind kind = supply_.suppression.kind;
  const bool carries = kind == Kind::rc || (kind == Kind::diode && current > slack) ||
                       (kind == Kind::varistor && std::fabs(current) > slack);
  path_ = carries ? Path::suppression : Path::none;
  sign_ = current > 0 ? 1 : -1;
  if (carries) return Effect::none;
  if (coil_ == Coil::closed) return Effect::blocked;
  return current == 0 ? Effect::opened : Effect::cut;
}

/// Behind a closed switch and a rectifier: what holds after a jump of the voltage or a change of the switch.
void SupplyModes::choose_path(double t, double current) {
  if (!rectified_on()) return;
  turn_ = voltage(t) < 0 ? -1 : 1;
  const bool takes = !diode() || over_diode(t, current, false) > 0;
  switch (path_) {
    case Path::none:
      if (behind(t, false) > 0) path_ = Path::source;
      break;
    case Path::suppression:
      if (takes) path_ = Path::source;
      break;
    case Path::source:
      if (!takes && current > slack) leave_source(current);
      break;
  }
}

SupplyModes::Effect SupplyModes::pass_guard(double t, double current) {
  switch (path_) {
    case Path::source:
      return pass_source(t, current);
    case Path::suppression:
      if (rectified_on() && current > slack) {
        path_ = Path::source;
        turn_ = voltage(t) < 0 ? -1 : 1;
        return Effect::none;
      }
      path_ = Path::none;
      return coil_ == Coil::open ? Effect::cut : Effect::blocked;
    case Path::none:
      if (rectified_on() && (!diode() || -behind(t, true) <= supply_.suppression.forward)) {
        path_ = Path::source;
        turn_ = voltage(t) < 0 ? -1 : 1;
      } else if (diode()) {
        path_ = Path::suppression;
        sign_ = 1;
      }
      break;
  }
  return Effect::none;
}

SupplyModes::Effect SupplyModes::pass_source(double t, double current) {
  if (rectifies()) {
    if (current <= slack) {
      path_ = Path::none;
      return Effect::blocked;
    }
    // the event may lie a rounding error before its zero: the nearest one it is
    if (full_wave() && !(diode() && over_diode(t, current, false) < turn_ * voltage(t))) {
      turn_ = -turn_;
      return Effect::none;
    }
    return leave_source(current);
  }
  if (coil_ == Coil::opening) {
    coil_ = Coil::open;
    if (holding_ > 0) return leave_source(current);
    path_ = Path::none;
    return Effect::opened;
  }
  if (coil_ == Coil::closed) {
    latched_ = !latched_;
    sign_ = current > 0 ? 1 : -1;
  }
  return Effect::none;
}

}  // namespace powbench::sim
