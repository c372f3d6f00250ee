#include <map>
#include <mutex>
#include <vector>

#include "sim/models/counting_potential.h"
#include "sim/models/mechanics_kinds.h"
#include "sim/models/modal_closing.h"

namespace powbench::sim {
namespace {

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
    {
      const std::scoped_lock lock(mutex_);
      const auto known = parts_.find(key);
      if (known != parts_.end()) return known->second;
    }
    const ModalParts made =
        modal_parts(s);  // others with other parts do not wait; two with the same get the same
    const std::scoped_lock lock(mutex_);
    if (parts_.size() >= 64) parts_.clear();
    return parts_.emplace(key, made).first->second;
  }

 private:
  std::mutex mutex_;
  std::map<std::vector<double>, ModalParts> parts_;
};

/// The same with all fields.
KnownParts& known_parts() {
  static KnownParts parts;
  return parts;
}

Trajectory run_modal(const FieldRung& fields, const Case& c, double duration, double step, double sample_dt) {
  refuse_unknown(modal_mechanics(), c);
  ModalClosingOptions o;
  o.step = step;
  o.duration = duration;
  o.sample = sample_dt;
  o.pressed_gap = fields.pressed_gap;
  const CountingPotential potential(fields.potential(c));
  return potential.told(modal_closing(c.specimen, c.conditions, potential, known_parts().of(c.specimen), o));
}

Rung modal_rung(const FieldRung& fields) {
  Rung r{fields.name, "modal", fields.meaning + ", base and bridges bend by modes",
         [fields](const Case& c, double duration, double step, double sample_dt) {
           return run_modal(fields, c, duration, step, sample_dt);
         }};
  r.setting = "step";
  r.settings = {0.8, 0.4, 0.2, 0.1, 0.05};
  if (fields.costly) r.settings = {0.8, 0.4};
  r.costly = fields.costly;
  return r;
}

}  // namespace

Mechanics modal_mechanics() {
  return {.name = "modal",
          .detail = 1,
          .any_fields = true,
          .costly = false,
          .unknown = [](const Case& c) { return beyond_deforming_parts("modal", c); },
          .rung = modal_rung};
}

}  // namespace powbench::sim
