#include "fmu/instance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fmu/resource.h"
#include "sim/specimen/specimen_fields.h"

namespace powbench::fmu {
namespace {

using Causality = Variable::Causality;
using Kind = Variable::Kind;

constexpr int most_rounds = 100;

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument(what);
}

}  // namespace

Instance::Instance(Fmi fmi, bool exchange, const std::string& folder, const std::string& token)
    : fmi_(fmi), exchange_(exchange) {
  const std::string text = read_resource(folder);
  if (token != token_of(text))
    refuse("the token '" + token + "' is not that of this FMU, '" + token_of(text) + "'");
  specimen_ = parse_resource(text);
  table_ = variables(specimen_, fmi);
  reset();
}

void Instance::reset() {
  values_.clear();
  for (const auto& v : table_) values_.push_back(v.start);
  unit_.reset();
  input_ = {};
  shown_ = {};
  start_ = 0;
  stop_.reset();
  mode_ = Mode::instantiated;
}

void Instance::require_mode(std::initializer_list<Mode> allowed) const {
  if (std::find(allowed.begin(), allowed.end(), mode_) != allowed.end()) return;
  constexpr const char* names[] = {"instantiated", "initialization", "event", "continuous-time",
                                   "step",         "terminated",     "error"};
  refuse(std::string("not allowed in the mode ") + names[static_cast<std::size_t>(mode_)]);
}

const Variable& Instance::variable(std::uint32_t reference, bool boolean) const {
  if (reference >= table_.size() || table_[reference].boolean != boolean)
    refuse("value reference " + std::to_string(reference) + " is no " +
           (boolean ? "Boolean" : "real number"));
  return table_[reference];
}

UnitSettings Instance::settings() const {
  UnitSettings s;
  s.specimen = specimen_;
  for (const auto& v : table_) {
    const double value = values_[v.reference];
    if (v.kind == Kind::source_volts) s.source_volts = value;
    if (v.kind == Kind::source_hertz) s.source_hertz = value;
    if (v.kind == Kind::source_phase) s.source_phase = value;
    if (v.kind == Kind::tolerance) s.tolerance = value;
    if (v.kind != Kind::number || value == v.start) continue;  // the resource has all digits
    const auto& field = sim::specimen_fields()[static_cast<std::size_t>(v.index)];
    field.set(s.specimen, value * field.si_per_unit);
  }
  return s;
}

ContactorUnit& Instance::unit() {
  if (!unit_) {
    require_mode({Mode::initialization});
    unit_ = std::make_shared<ContactorUnit>(settings(), start_, input_);
    shown_ = unit_->facts();
  }
  return *unit_;
}

double Instance::number(std::uint32_t reference) {
  const Variable& v = variable(reference, false);
  switch (v.kind) {
    case Kind::time:
      return unit_ ? unit_->now() : start_;
    case Kind::coil_voltage:
      return input_.volts[0];
    case Kind::coil_voltage_rate:
      return input_.volts[1];
    case Kind::coil_temperature:
      return input_.kelvin;
    case Kind::seat_time:
      return unit(), shown_.seat_time;
    case Kind::touch_time:
      return unit(), shown_.touch_time[static_cast<std::size_t>(v.index)];
    case Kind::state:
      return unit().state()[static_cast<std::size_t>(v.index)];
    case Kind::rate: {
      unit();
      std::vector<double> rates(static_cast<std::size_t>(driven().states()));
      unit_->derivatives(rates);
      return rates[static_cast<std::size_t>(v.index)];
    }
    default:
      break;
  }
  if (v.causality == Causality::parameter) return values_[reference];
  const UnitOutput o = unit().output();
  const auto& pole = o.poles[static_cast<std::size_t>(v.index)];
  switch (v.kind) {
    case Kind::current:
      return o.current;
    case Kind::linkage:
      return o.linkage;
    case Kind::pull:
      return o.pull;
    case Kind::travel:
      return o.travel;
    case Kind::speed:
      return o.speed;
    case Kind::stop_force:
      return o.stop_force;
    case Kind::bridge_travel:
      return pole.travel;
    case Kind::force_a:
      return pole.force_a;
    default:
      return pole.force_b;
  }
}

bool Instance::flag(std::uint32_t reference) {
  const Variable& v = variable(reference, true);
  if (v.kind == Kind::coil_closed) return input_.closed;
  unit();
  return v.kind == Kind::seated ? shown_.seated : shown_.closed[static_cast<std::size_t>(v.index)];
}

void Instance::require_settable(const Variable& v) const {
  if (v.causality == Causality::parameter) return require_mode({Mode::instantiated, Mode::initialization});
  if (v.causality != Causality::input) refuse(v.name + " may not be set");
  const bool in_event_only = v.discrete && (exchange_ || event_mode_used_);
  if (in_event_only) return require_mode({Mode::instantiated, Mode::initialization, Mode::event});
  require_mode({Mode::instantiated, Mode::initialization, Mode::event, Mode::continuous, Mode::step});
}

void Instance::set_number(std::uint32_t reference, double value) {
  const Variable& v = variable(reference, false);
  require_settable(v);
  if (!std::isfinite(value)) refuse(v.name + ": allowed any finite number");
  if (v.kind == Kind::coil_voltage)
    input_.volts = {value, fmi_ == Fmi::three ? input_.volts[1] : 0.0};
  else if (v.kind == Kind::coil_voltage_rate)
    input_.volts[1] = value;
  else if (v.kind == Kind::coil_temperature)
    input_.kelvin = value;
  else
    values_[reference] = value;
  if (mode_ == Mode::initialization) unit_.reset();
}

void Instance::set_flag(std::uint32_t reference, bool value) {
  require_settable(variable(reference, true));
  input_.closed = value;
  if (mode_ == Mode::initialization) unit_.reset();
}

void Instance::set_input_derivative(std::uint32_t reference, int order, double value) {
  const Variable& v = variable(reference, false);
  if (v.kind != Kind::coil_voltage) refuse(v.name + " takes no derivatives");
  if (order < 1 || order > 5) refuse("order of a derivative = " + std::to_string(order) + ", allowed 1 .. 5");
  if (!std::isfinite(value)) refuse(v.name + ": allowed any finite number");
  input_.volts[static_cast<std::size_t>(order)] = value;
}

void Instance::prepare(double start, std::optional<double> stop) {
  if (!std::isfinite(start)) refuse("start time: allowed any finite number");
  if (stop && !(*stop >= start)) refuse("stop time: allowed the start time and later");
  start_ = start;
  stop_ = stop;
}

void Instance::enter_initialization() {
  mode_ = Mode::initialization;
}

void Instance::exit_initialization() {
  unit();
  mode_ = exchange_ || event_mode_used_ ? Mode::event : Mode::step;
}

Instance::Step Instance::step(double t, double h) {
  ContactorUnit& u = unit();
  const double slack = 1e-9 * std::max(1e-3, std::fabs(t));
  if (!(std::fabs(t - u.now()) <= slack))
    refuse("communication point " + std::to_string(t) + " s, allowed the end of the last step, " +
           std::to_string(u.now()) + " s");
  if (!(h > 0 && std::isfinite(t + h) && t + h > u.now())) refuse("communication step: allowed above 0 s");
  if (stop_ && t + h > *stop_ + slack) refuse("the step ends after the stop time");
  try {
    const auto done = u.advance(t + h, input_, early_);
    Step s;
    s.reached = done.reached;
    s.early = done.event && done.reached < t + h;
    s.event = done.event && event_mode_used_;
    if (!event_mode_used_) shown_ = u.facts();
    if (fmi_ == Fmi::two) input_.volts = {input_.volts[0]};
    return s;
  } catch (const std::runtime_error&) {
    mode_ = Mode::failed;
    throw;
  }
}

void Instance::enter_event_mode() {
  mode_ = Mode::event;
  rounds_ = 0;
}

Instance::Update Instance::update() {
  Update result;
  if (exchange_) {
    unit().set_input(input_);
    result.values_changed = unit().switch_modes();
    result.again = ++rounds_ < most_rounds && unit().mode_ended();
  }
  shown_ = unit().facts();
  return result;
}

ContactorUnit& Instance::driven() {
  unit().set_input(input_);
  return *unit_;
}

struct Instance::Saved {
  Mode mode;
  std::vector<double> values;
  UnitInput input;
  std::shared_ptr<ContactorUnit> unit;
  std::shared_ptr<const ContactorUnit::Snapshot> snapshot;
  UnitFacts shown;
  double start;
  std::optional<double> stop;
};

std::shared_ptr<const Instance::Saved> Instance::save() const {
  return std::make_shared<Saved>(
      Saved{mode_, values_, input_, unit_, unit_ ? unit_->snapshot() : nullptr, shown_, start_, stop_});
}

void Instance::go_back(const Saved& s) {
  mode_ = s.mode;
  values_ = s.values;
  input_ = s.input;
  unit_ = s.unit;
  if (unit_) unit_->go_back(*s.snapshot);
  shown_ = s.shown;
  start_ = s.start;
  stop_ = s.stop;
}

}  // namespace powbench::fmu
