#include "sim/models/mechanics.h"

#include <array>
#include <stdexcept>

#include "sim/mechanics/contact_damping.h"
#include "sim/models/mechanics_kinds.h"
#include "sim/specimen/specimen_remanence.h"

namespace powbench::sim {

std::span<const Mechanics> all_mechanics() {
  static const std::array kinds{plant_mechanics(), rigid_mechanics(), modal_mechanics(),
                                deformable_mechanics()};
  return kinds;
}

const Mechanics& mechanics_named(std::string_view name) {
  for (const Mechanics& m : all_mechanics())
    if (m.name == name) return m;
  throw std::invalid_argument("mechanics = " + std::string(name) + ", allowed " +
                              names_of(all_mechanics(), ", "));
}

std::vector<std::string> automatic_mechanics(const Case& c, bool costly) {
  std::vector<std::string> out;
  for (const Mechanics& m : all_mechanics())
    if (m.any_fields && (costly || !m.costly) && m.unknown(c).empty()) out.emplace_back(m.name);
  return out;
}

std::string_view cheapest_equal(std::string_view name, const FieldRung& fields, const Case& c) {
  const int detail = mechanics_named(name).detail;
  for (const Mechanics& m : all_mechanics())
    if (m.detail == detail && (m.any_fields || fields.name == circuit_field().name) && m.unknown(c).empty())
      return m.name;
  return name;
}

std::string beyond_deforming_parts(std::string_view mechanics, const Case& c) {
  if (std::string beyond = rigid_only(c.specimen); !beyond.empty()) return beyond;
  const std::string rung = "the rung " + std::string(mechanics);
  const std::string instead = "; take plant or rigid";
  if (!plain(c.bench.mains) || c.bench.coil_switch.kind != CoilSwitch::Kind::ideal ||
      c.bench.coil_switch.hold_period > 0 || c.bench.suppression.kind != Suppression::Kind::none)
    return "supply, switch: " + rung + " knows a plain alternating source and an ideal switch only" + instead;
  if (remanence(c.specimen).present())
    return "magnet.coercive_field_A_per_m: allowed 0 on " + rung + ", which has no remanence" + instead;
  if (c.specimen.base.core_mass > 0)
    return "base.core_mass_g: allowed 0 on " + rung + ", whose static core is part of the base" + instead;
  return "";
}

void refuse_unknown(const Mechanics& m, const Case& c) {
  if (const std::string what = m.unknown(c); !what.empty()) throw std::invalid_argument(what);
}

Rung scene_rung(const FieldRung& fields, std::string_view mechanics) {
  const Mechanics& m = mechanics_named(mechanics);
  if (!m.any_fields && fields.name != circuit_field().name)
    throw std::invalid_argument("mechanics = " + std::string(m.name) +
                                ": allowed with fields = circuit only, not " + fields.name + "; take rigid");
  return m.rung(fields);
}

ClosingModel closing_model(const Rung& rung) {
  return {rung.name(), [rung](const Specimen& s, const Conditions& c, double duration, double tolerance) {
            try {
              return rung
                  .run({s, c, {}}, duration, rung.settings.empty() ? tolerance : rung.settings.back(), 0)
                  .truth;
            } catch (const std::exception&) {
              return ClosingTruth{};
            }
          }};
}

std::vector<Rung> closing_rungs() {
  return {plant_mechanics().rung(circuit_field()), rigid_mechanics().rung(circuit_field())};
}

}  // namespace powbench::sim
