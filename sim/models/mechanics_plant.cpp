#include "sim/mechanics/contact_damping.h"
#include "sim/models/mechanics_kinds.h"

namespace powbench::sim {
namespace {

Rung plant_rung(const FieldRung& fields) {
  return {fields.name, "plant", "lumped circuit, core, base and bridges of the simulated rig",
          [](const Case& c, double duration, double tolerance, double sample_dt) {
            return simulate(c.specimen, c.conditions, duration, sample_dt, tolerance, c.bench);
          }};
}

}  // namespace

Mechanics plant_mechanics() {
  return {.name = "plant",
          .detail = 0,
          .any_fields = false,
          .costly = false,
          .unknown = [](const Case& c) { return rigid_only(c.specimen); },
          .rung = plant_rung};
}

}  // namespace powbench::sim
