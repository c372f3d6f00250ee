#include "sim/supply/supply_modes.h"

#include <algorithm>
#include <cmath>

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
  if (s.gate_period > 0)
    require_range("switch gate_period", s.gate_period, s.gate_pulse, 1e3, "s, from the gate_pulse");
}

void require_valid(const Supply& s) {
  require_valid(s.mains);
  require_valid(s.coil_switch);
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
    const bool pulse_again = due_.size() == 1 && change.act == Act::close &&
                             supply_.coil_switch.gate_period > 0 &&
                             supply_.coil_switch.kind == CoilSwitch::Kind::triac;
    if (pulse_again) schedule(change.time);
    due_.erase(due_.begin());
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
  return effect;
}

void SupplyModes::close(double current) {
  if (coil_ == Coil::open) latched_ = std::fabs(current) >= latching_;
  coil_ = Coil::closed;
}

SupplyModes::Effect SupplyModes::part(double current) {
  if (coil_ != Coil::closed) return Effect::none;
  const double size = std::fabs(current);
  const bool stays = size > holding_ && (latched_ || size >= latching_);
  coil_ = stays ? Coil::opening : Coil::open;
  sign_ = current > 0 ? 1 : -1;
  if (stays) return Effect::none;
  return current == 0 ? Effect::opened : Effect::cut;
}

SupplyModes::Effect SupplyModes::pass_current(double current) {
  if (coil_ == Coil::opening) {
    coil_ = Coil::open;
    return holding_ > 0 ? Effect::cut : Effect::opened;
  }
  if (coil_ == Coil::closed) {
    latched_ = !latched_;
    sign_ = current > 0 ? 1 : -1;
  }
  return Effect::none;
}

}  // namespace powbench::sim
