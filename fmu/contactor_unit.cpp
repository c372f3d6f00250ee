#include "fmu/contactor_unit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "core/units.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/models/rigid_closing.h"
#include "sim/specimen/specimen_remanence.h"
#include "sim/specimen/validate.h"

namespace powbench::fmu {
namespace {

constexpr double first_step = 1e-6;    // s
constexpr double largest_step = 1e-3;  // s

// A mode ends this far beyond its limit, so that no indicator is zero just after an event: root finders stop at that.
constexpr double depth_margin = 1e-12;  // m
constexpr double other_margin = 1e-9;   // N, m/s, A or a share of a force

void require(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  char text[160];
  std::snprintf(text, sizeof text, "%s = %.6g, allowed %.6g .. %.6g", name, value, low, high);
  throw std::invalid_argument(text);
}

sim::CoilDrive drive_of(const UnitSettings& s, const sim::SpecimenPotential& potential, double resistance) {
  sim::CoilDrive drive;
  drive.potential = &potential;
  drive.resistance = resistance;
  drive.ring_resistance = potential.ring_resistance();
  drive.supply.mains.volts = s.source_volts;
  drive.supply.mains.hertz = s.source_hertz;
  drive.supply.mains.phase = s.source_phase;
  drive.remanence = sim::remanence(s.specimen);
  drive.pressed_gap = true;
  return drive;
}

const UnitSettings& checked(const UnitSettings& s) {
  require_valid(s);
  return s;
}

}  // namespace

void require_valid(const UnitSettings& s) {
  sim::require_valid(s.specimen);
  require("source.volts", s.source_volts, 0, 1e4);
  require("source.hertz", s.source_hertz, 1, 1000);
  require("source.phase", s.source_phase, -1e9, 1e9);
  require("tolerance", s.tolerance, 1e-12, 1e-4);
}

ContactorUnit::ContactorUnit(const UnitSettings& settings, double t, const UnitInput& input)
    : settings_(checked(settings)),
      potential_(std::make_shared<sim::SpecimenPotential>(settings.specimen)),
      contactor_(sim::rigid_parts(settings.specimen),
                 drive_of(settings, *potential_, resistance(input.kelvin))),
      solver_(contactor_, settings.tolerance, largest_step),
      core_rest_(-sim::stop_rest_depth(settings.specimen)),
      now_(t) {
  facts_.touch_time.fill(-1);
  contactor_.equilibrium(y_);
  for (int j = 0; j < poles(); ++j) {
    bridge_rest_[static_cast<std::size_t>(j)] = y_[contactor_.bridge_state(j)];
    for (int group = 0; group < sim::core_group; ++group)
      guards_.push_back(contactor_.lane_of(group * sim::rigid_lanes + j));
  }
  for (int k = 0; k < 4; ++k) guards_.push_back(sim::core_group * sim::rigid_lanes + k);
  for (int k = Contactor::gap_guard; k <= Contactor::coil_guard; ++k) guards_.push_back(k);
  input_ = input;
  input_.closed = false;
  set_input(input);
  solver_.restart(t, y_, first_step);
}

double ContactorUnit::resistance(double kelvin) const {
  require("coil_temperature", kelvin, 150, 600);
  const auto& coil = settings_.specimen.coil;
  return coil.resistance * (1 + coil.temperature_coefficient * (kelvin - 293.15));
}

void ContactorUnit::set_input(const UnitInput& input) {
  for (const double v : input.volts)
    if (!std::isfinite(v)) throw std::invalid_argument("coil_voltage: allowed any finite number");
  sim::StatedVoltage voltage{now_, input.volts};
  double factorial = 1;
  for (std::size_t k = 1; k < voltage.c.size(); ++k) voltage.c[k] /= factorial *= static_cast<double>(k);
  contactor_.state_feed(voltage, resistance(input.kelvin));
  if (input.closed != input_.closed) contactor_.set_coil(now_, y_, input.closed);
  input_ = input;
}

ContactorUnit::Advance ContactorUnit::advance(double t_end, const UnitInput& input, bool stop) {
  const bool held = std::all_of(input.volts.begin() + 1, input.volts.end(), [](double v) { return v == 0; });
  if (!held || !(input == input_)) {
    const double step = std::max(std::min(t_end - now_, solver_.memory().step), 1e-9);
    set_input(input);
    solver_.restart(now_, y_, step);
  }
  Advance result;
  const auto waits = [&] { return solver_.end() == t_end && solver_.memory().pending != 0; };
  while (solver_.end() < t_end || waits()) {
    const auto before = contactor_.events().size();
    if (!solver_.extend())
      throw std::runtime_error("the step became too small at t = " + std::to_string(solver_.end()) + " s");
    if (contactor_.events().size() == before) continue;
    result.event = true;
    if (stop) {
      t_end = solver_.begin();
      break;
    }
  }
  take_events();
  solver_.state(t_end, y_);
  now_ = result.reached = t_end;
  return result;
}

void ContactorUnit::take_events() {
  for (const auto& e : contactor_.events()) {
    const auto place = sim::contact_place(e.contact);
    const auto j = static_cast<std::size_t>(place.part);
    if (place.kind == sim::ContactKind::pole && place.end == 0 && e.closes && facts_.seat_time < 0)
      facts_.seat_time = e.time;
    if (place.kind != sim::ContactKind::pad) continue;
    pads_[j][static_cast<std::size_t>(place.end)] = e.closes;
    facts_.closed[j] = pads_[j][0] && pads_[j][1];
    if (facts_.closed[j] && facts_.touch_time[j] < 0) facts_.touch_time[j] = e.time;
  }
  contactor_.events().clear();
  const int pole = sim::core_group * sim::rigid_lanes;
  facts_.seated = contactor_.is_pressing(pole) || contactor_.is_pressing(pole + 1);
}

UnitOutput ContactorUnit::output() const {
  const auto& c = contactor_;
  UnitOutput o;
  o.current = c.conducts() ? c.current(y_) : 0.0;
  o.linkage = y_[2 * c.dof()];
  o.pull = c.pull(now_, y_);
  o.travel = y_[0] - core_rest_;
  o.speed = y_[c.dof()];
  const int pole = sim::core_group * sim::rigid_lanes;
  o.stop_force = c.force_of(pole, y_) + c.force_of(pole + 1, y_);
  for (int j = 0; j < poles(); ++j) {
    const auto k = static_cast<std::size_t>(j);
    o.poles[k] = {y_[c.bridge_state(j)] - bridge_rest_[k], c.force_of(j, y_),
                  c.force_of(sim::rigid_lanes + j, y_)};
  }
  return o;
}

void ContactorUnit::set_state(std::span<const double> y) {
  std::copy(y.begin(), y.end(), y_);
}

void ContactorUnit::derivatives(std::span<double> rates) const {
  alignas(64) double dy[Solver::capacity] = {};
  contactor_.derivative(now_, y_, dy);
  std::copy_n(dy, rates.size(), rates.begin());
}

void ContactorUnit::indicate(std::span<double> z) const {
  Contactor::GuardSet g;
  contactor_.guards(now_, y_, nullptr, g);
  for (std::size_t k = 0; k < guards_.size(); ++k)
    z[k] = g.value[guards_[k]] + (guards_[k] <= Contactor::gap_guard ? depth_margin : other_margin);
}

bool ContactorUnit::mode_ended() const {
  std::vector<double> z(guards_.size());
  indicate(z);
  return std::any_of(z.begin(), z.end(), [](double v) { return v < 0; });
}

bool ContactorUnit::switch_modes() {
  std::vector<double> z(guards_.size());
  indicate(z);
  std::uint64_t which = 0;
  for (std::size_t k = 0; k < z.size(); ++k)
    if (z[k] < 0) which |= std::uint64_t{1} << guards_[k];
  if (which == 0) return false;
  double t = now_;
  contactor_.flip(t, y_, which);
  take_events();
  return true;
}

struct ContactorUnit::Snapshot {
  Contactor contactor;
  Solver solver;
  UnitInput input;
  UnitFacts facts;
  decltype(ContactorUnit::pads_) pads;
  double now;
  std::array<double, Solver::capacity> y;
};

std::shared_ptr<const ContactorUnit::Snapshot> ContactorUnit::snapshot() const {
  auto s = std::make_shared<Snapshot>(Snapshot{contactor_, solver_, input_, facts_, pads_, now_, {}});
  std::copy_n(y_, Solver::capacity, s->y.begin());
  return s;
}

void ContactorUnit::go_back(const Snapshot& s) {
  contactor_ = s.contactor;
  solver_ = s.solver;  // of this unit: it points at contactor_
  input_ = s.input;
  facts_ = s.facts;
  pads_ = s.pads;
  now_ = s.now;
  std::copy(s.y.begin(), s.y.end(), y_);
}

std::vector<StateName> state_names(const sim::Specimen& s) {
  std::vector<StateName> q = {
      {"core.travel", "m", ""}, {"core.tilt", "rad", ""}, {"static_core.travel", "m", ""}};
  const auto parts = sim::rigid_parts(s);
  for (std::size_t k = 1; k <= parts.modes.size(); ++k)
    q.push_back({"base.mode[" + std::to_string(k) + "]", "m", ""});
  for (const auto& [name, unit] : {std::pair{"travel", "m"}, {"angle", "rad"}})
    for (int j = 1; j <= s.bridges.poles; ++j)
      q.push_back({"bridge[" + std::to_string(j) + "]." + name, unit, ""});
  const std::size_t n = q.size();
  for (auto& row : q) row.rate_unit = row.unit + "/s";
  for (std::size_t k = 0; k < n; ++k) {
    const auto row = q[k];
    q.push_back({row.name + "_rate", row.rate_unit, row.unit + "/s2"});
  }
  q.push_back({"coil.flux_linkage", "Wb", "V"});
  if (sim::SpecimenPotential(s).has_ring()) q.push_back({"ring.flux", "Wb", "V"});
  if (sim::remanence(s).present()) q.push_back({"iron.coercive_current", "A", "A/s"});
  return q;
}

int indicator_count(const sim::Specimen& s) {
  return 4 * s.bridges.poles + 4 + sim::RigidContactor<double>::coil_guard -
         sim::RigidContactor<double>::gap_guard + 1;
}

}  // namespace powbench::fmu
