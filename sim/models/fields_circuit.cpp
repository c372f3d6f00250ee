#include "sim/models/field_kinds.h"
#include "sim/specimen/specimen_potential.h"

namespace powbench::sim {

FieldRung circuit_field() {
  return {"circuit", "lumped circuit of the specimen",
          [](const Case& c) { return std::make_shared<SpecimenPotential>(c.specimen); }, true, false};
}

Fields circuit_fields() {
  return {
      .name = "circuit", .costly = false, .unknown = no_circuit, .rung = [](const Specimen&, FieldTables&) {
        return circuit_field();
      }};
}

}  // namespace powbench::sim
