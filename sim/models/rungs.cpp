#include "sim/models/rungs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>

#include "core/units.h"
#include "sim/magnetics/circuit/remanence.h"
#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/mechanics/rigid_closing.h"
#include "sim/solid/modal_closing.h"
#include "sim/solid/solid_closing.h"
#include "sim/specimen/specimen_potential.h"
#include "sim/specimen/specimen_steel.h"

namespace powbench::sim {
namespace {

/// The field as a potential that remembers its last solution. Not for two threads. Past the largest gap of its mesh, m,
/// the energy goes on linearly in the gap: steps that are tried look there.
template <class Field>
class LivePotential final : public MagneticPotential {
 public:
  template <class Design, class Options>
  LivePotential(const Design& design, const Options& options,
                double largest_gap = std::numeric_limits<double>::infinity())
      : field_(design, options), largest_gap_(largest_gap) {}

  bool has_ring() const override { return field_.has_ring(); }
  MagneticResponse at(const MagneticState& s) const override {
    if (const double sum = s.psi + s.gap + (has_ring() ? s.ring : 0); !std::isfinite(sum)) {
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();  // of a step that is tried in vain
      return {nan, nan, nan, nan, nan, nan, nan, nan, nan, nan};
    }
    field_.set_gap(std::clamp(s.gap, 0.0, largest_gap_));
    constexpr double nothing = 1e-30, little = 1e-9;  // Wb: no flux, and one that saturates nothing
    if (std::fabs(s.psi) < nothing && (!has_ring() || std::fabs(s.ring) < nothing)) {
      const auto linear = field_.at_flux(little, 0, {}).response;
      MagneticResponse none;
      none.current_psi = linear.current_psi;
      none.current_ring = linear.current_ring;
      none.ring_ring = linear.ring_ring;
      return none;
    }
    auto point = field_.at_flux(s.psi, s.ring, last_);
    last_ = point.newton.converged ? std::move(point.a) : std::vector<double>{};
    auto& r = point.response;
    if (const double past = s.gap - largest_gap_; past > 0) {
      r.energy += r.pull * past;
      r.current += r.current_gap * past;
      r.ring_current += r.ring_gap * past;
      r.beyond = true;
    }
    return r;
  }

 private:
  mutable Field field_;
  mutable std::vector<double> last_;
  double largest_gap_;
};

/// Counts the states of the steps taken, and of these the ones that its potential had to extrapolate: a step that was
/// tried in vain may have looked anywhere. For one run.
class CountingPotential final : public MagneticPotential {
 public:
  explicit CountingPotential(std::shared_ptr<const MagneticPotential> inner) : inner_(std::move(inner)) {}

  bool has_ring() const override { return inner_->has_ring(); }
  MagneticResponse at(const MagneticState& s) const override {
    const MagneticResponse r = inner_->at(s);
    ++tried_.states, tried_.beyond += r.beyond ? 1 : 0;
    return r;
  }
  void tried(bool taken) const override {
    if (taken) states_ += tried_.states, beyond_ += tried_.beyond;
    tried_ = {};
  }
  Trajectory told(Trajectory t) const {
    tried(true);  // by an engine that tells nothing, or after its last step
    t.field_states = states_, t.field_beyond = beyond_;
    return t;
  }

 private:
  std::shared_ptr<const MagneticPotential> inner_;
  mutable std::int64_t states_ = 0, beyond_ = 0;
  struct Tried {
    std::int64_t states = 0, beyond = 0;
  };
  mutable Tried tried_;  ///< since the last step
};

void refuse_unknown(std::string_view mechanics, const Case& c) {
  if (const std::string what = unknown_to(mechanics, c); !what.empty()) throw std::invalid_argument(what);
}

/// State at a time between the samples of a closing with deforming parts.
PlantSample between(const std::vector<SolidClosingSample>& list, double t, std::size_t& at) {
  while (at + 2 < list.size() && list[at + 1].time < t) ++at;
  const auto &a = list[at], &b = list[std::min(at + 1, list.size() - 1)];
  const double share = b.time > a.time ? std::clamp((t - a.time) / (b.time - a.time), 0.0, 1.0) : 0.0;
  const auto mix = [&](double x, double y) { return x + share * (y - x); };
  PlantSample s;
  s.time = t;
  s.coil_current = mix(a.current, b.current);
  s.flux_linkage = mix(a.flux, b.flux);
  s.pull = mix(a.pull, b.pull);
  s.travel = mix(a.travel, b.travel);
  s.base = mix(a.base, b.base);
  s.core_velocity = b.time > a.time ? (b.travel - a.travel) / (b.time - a.time) : 0;
  s.force_a = s.force_b = 0.5 * mix(a.pad_force, b.pad_force);
  return s;
}

/// The explicit rung's result in the words of the others.
Trajectory trajectory(const SolidClosingResult& r, const Case& c, double duration, double sample_dt) {
  Trajectory t;
  if (r.first_touch >= 0) t.truth.touch = t.truth.touch_a = t.truth.touch_b = r.first_touch;
  if (r.last_touch >= 0) t.truth.settled = r.last_touch;
  if (r.core_seat >= 0) t.truth.core_seat = r.core_seat;
  for (const auto& [release, touch] : r.open) t.truth.openings.push_back({release, touch});
  t.evaluations = r.rigid_steps + r.deformed_steps;
  t.energy_residual = r.residual;
  std::size_t at = 0;
  for (std::size_t k = 1;
       sample_dt > 0 && static_cast<double>(k) * sample_dt <= duration && !r.samples.empty(); ++k) {
    PlantSample s = between(r.samples, static_cast<double>(k) * sample_dt, at);
    s.mains_voltage = s.coil_voltage = mains_voltage(closing_mains(c.conditions), MainsPiece{}, s.time);
    t.truth.peak_current = std::max(t.truth.peak_current, std::fabs(s.coil_current));
    t.samples.push_back(s);
  }
  return t;
}

/// Reductions by what they depend on: one takes longer than the closing that uses it.
class KnownParts {
 public:
  ModalParts of(const Specimen& s) {
    const auto& b = s.bridges;
    const std::vector<double> key{static_cast<double>(b.poles),
                                  b.half_length,
                                  b.seat_half_length,
                                  b.mass,
                                  b.gap,
                                  s.core.travel,
                                  s.core.mass,
                                  s.base.mass};
    const std::scoped_lock lock(mutex_);
    const auto known = parts_.find(key);
    if (known != parts_.end()) return known->second;
    if (parts_.size() >= 64) parts_.clear();
    return parts_.emplace(key, modal_parts(s)).first->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::vector<double>, ModalParts> parts_;
};

Trajectory run_modal(const FieldRung& field, KnownParts& parts, const Case& c, double duration, double step,
                     double sample_dt) {
  refuse_unknown("modal", c);
  ModalClosingOptions o;
  o.step = step;
  o.duration = duration;
  o.sample = sample_dt;
  o.pressed_gap = field.pressed_gap;
  const CountingPotential potential(field.potential(c));
  return potential.told(modal_closing(c.specimen, c.conditions, potential, parts.of(c.specimen), o));
}

Trajectory run_explicit(const FieldRung& field, const Case& c, double duration, double cell_mm,
                        double sample_dt) {
  refuse_unknown("explicit", c);
  SolidClosingOptions o;
  o.cell = cell_mm * 1e-3;
  o.end = std::min(duration, explicit_duration);
  o.pressed_gap = field.pressed_gap;
  const CountingPotential potential(field.potential(c));
  return potential.told(
      trajectory(solid_closing(c.specimen, c.conditions, potential, o), c, duration, sample_dt));
}

}  // namespace

MagnetDesign magnet_design(const Specimen& s) {
  MagnetDesign d;
  d.shape = s.shape;
  d.steel = steel_of(s.magnet);
  d.turns = s.coil.turns;
  d.residual_gap = s.magnet.residual_gap;
  return d;
}

FieldRung circuit_field() {
  return {"circuit", "lumped circuit of the specimen",
          [](const Case& c) { return std::make_shared<SpecimenPotential>(c.specimen); }, true, false};
}

FieldRung pure_field(std::string name, std::string meaning,
                     std::shared_ptr<const MagneticPotential> potential) {
  return {std::move(name), std::move(meaning), [potential](const Case&) { return potential; }, false, false};
}

FieldRung live_field(const MagnetDesign& design, const FieldOptions& options) {
  return {"field2d", "plane finite elements solved at every step",
          [design, options](const Case&) {
            return std::make_shared<LivePotential<MagnetField>>(design, options);
          },
          false, true};
}

FieldRung live_field(const std::shared_ptr<const DrawnMagnet>& drawing, const NewtonOptions& options) {
  return {"field2d", "finite elements of the drawing solved at every step",
          [drawing, options](const Case&) {
            constexpr double spare = 0.99;
            const double largest = spare * usable_gaps(*drawing).second - drawing->residual_gap;
            return std::make_shared<LivePotential<DrawnField>>(drawing, options, largest);
          },
          false, true};
}

std::string unknown_to(std::string_view mechanics, const Case& c) {
  if (mechanics == "rigid") return "";
  if (std::string beyond = rigid_only(c.specimen); !beyond.empty()) return beyond;
  if (mechanics == "plant") return "";
  const std::string rung = "the rung " + std::string(mechanics);
  const std::string instead = "; take plant or rigid";
  if (!plain(c.bench.mains) || c.bench.coil_switch.kind != CoilSwitch::Kind::ideal ||
      c.bench.coil_switch.hold_period > 0 || c.bench.suppression.kind != Suppression::Kind::none)
    return "supply, switch: " + rung + " knows a plain alternating source and an ideal switch only" + instead;
  if (remanence(c.specimen).present())
    return "magnet.coercive_field_A_per_m: allowed 0 on " + rung + ", which has no remanence" + instead;
  if (c.specimen.base.core_mass > 0)
    return "base.core_mass_g: allowed 0 on " + rung + ", whose static core is part of the base" + instead;
  if (mechanics == "explicit" && c.conditions.hold_time < explicit_duration)
    return "hold_time: allowed from " + std::to_string(explicit_duration * 1e3) + " ms on, " + rung +
           " does not switch off" + instead;
  return "";
}

Rung scene_rung(const FieldRung& field, std::string_view mechanics) {
  if (mechanics == "plant") {
    if (field.name != "circuit")
      throw std::invalid_argument("mechanics = plant: allowed with fields = circuit only, not " + field.name +
                                  "; take rigid");
    return closing_rungs()[0];
  }
  if (mechanics == "rigid") {
    if (field.name == "circuit") return closing_rungs()[1];
    const auto with = [field](bool ledger) {
      return [field, ledger](const Case& c, double duration, double tolerance, double sample_dt) {
        const CountingPotential potential(field.potential(c));
        return potential.told(simulate_rigid_with(potential, c.specimen, c.conditions, duration, sample_dt,
                                                  tolerance, ledger, c.bench));
      };
    };
    Rung r{field.name, "rigid", field.meaning + ", rigid parts", nullptr};
    // a field solved anew costs seconds: once is enough
    r.run = field.costly ? Audited::Run(with(false)) : Audited{with(false), with(true)};
    r.costly = field.costly;
    if (field.costly) r.settings = {1e-3, 1e-4, 1e-5};
    return r;
  }
  if (mechanics == "modal") {
    Rung r{field.name, "modal", field.meaning + ", base and bridges bend by modes",
           [field, parts = std::make_shared<KnownParts>()](const Case& c, double duration, double step,
                                                           double sample_dt) {
             return run_modal(field, *parts, c, duration, step, sample_dt);
           }};
    r.setting = "step";
    r.settings = {0.8, 0.4, 0.2, 0.1, 0.05};
    if (field.costly) r.settings = {0.8, 0.4};
    r.costly = field.costly;
    return r;
  }
  if (mechanics == "explicit") {
    Rung r{field.name, "explicit", field.meaning + ", deforming parts of finite elements",
           [field](const Case& c, double duration, double cell_mm, double sample_dt) {
             return run_explicit(field, c, duration, cell_mm, sample_dt);
           }};
    r.setting = "cell mm";
    r.settings = {6, 4, 3};
    r.costly = true;
    return r;
  }
  std::string known;
  for (const auto name : mechanics_names) known += (known.empty() ? "" : ", ") + std::string(name);
  throw std::invalid_argument("mechanics = " + std::string(mechanics) + ", allowed " + known);
}

}  // namespace powbench::sim
