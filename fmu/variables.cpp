#include "fmu/variables.h"

#include <string_view>

#include "fmu/contactor_unit.h"
#include "sim/specimen/specimen_fields.h"

namespace powbench::fmu {
namespace {

using Kind = Variable::Kind;
using Causality = Variable::Causality;

/// The unit that ends the key of a specimen file; "1": a pure number.
std::string unit_of_key(std::string_view key) {
  for (const auto& [ending, unit] : {std::pair<std::string_view, const char*>{"_A_per_m_per_T", "A/(m.T)"},
                                     {"_A_per_m", "A/m"},
                                     {"_N_per_m", "N/m"},
                                     {"_m_per_s", "m/s"},
                                     {"_per_K", "1/K"},
                                     {"_g_mm2", "g.mm2"},
                                     {"_mm2", "mm2"},
                                     {"_mm", "mm"},
                                     {"_um", "um"},
                                     {"_ohm", "ohm"},
                                     {"_Hz", "Hz"},
                                     {"_H", "H"},
                                     {"_T", "T"},
                                     {"_g", "g"},
                                     {"_N", "N"}})
    if (key.ends_with(ending)) return unit;
  return "1";
}

/// A number of the specimen that may be set: neither one that changes how many variables there are nor the drawing of
/// the magnet, which the circuit does not read.
bool may_be_set(const sim::SpecimenField& f) {
  return !f.whole && f.section != "shape";
}

class Table {
 public:
  void add(Kind kind, Causality causality, std::string name, std::string unit, std::string text,
           double start = 0, int index = 0) {
    Variable v;
    v.reference = static_cast<std::uint32_t>(rows.size());
    v.kind = kind, v.index = index, v.causality = causality;
    v.name = std::move(name), v.unit = std::move(unit), v.description = std::move(text);
    v.start = start;
    v.boolean = kind == Kind::coil_closed || kind == Kind::seated || kind == Kind::closed;
    v.discrete = v.boolean || kind == Kind::seat_time || kind == Kind::touch_time;
    rows.push_back(std::move(v));
  }
  std::vector<Variable> rows;
};

void add_outputs(Table& t, int poles) {
  const auto out = Causality::output;
  t.add(Kind::current, out, "coil_current", "A", "current of the coil");
  t.add(Kind::linkage, out, "flux_linkage", "Wb", "flux linkage of the coil with its leakage");
  t.add(Kind::pull, out, "magnetic_force", "N", "pull on the moving core, closing direction");
  t.add(Kind::travel, out, "core_position", "m", "travel of the core from its open position");
  t.add(Kind::speed, out, "core_speed", "m/s", "speed of the core, closing direction");
  t.add(Kind::stop_force, out, "core_force", "N", "contact force between the pole faces");
  t.add(Kind::seated, out, "core_seated", "", "the pole faces press on each other");
  t.add(Kind::seat_time, out, "seat_time", "s", "first touch of the pole faces; -1 before it");
  for (int j = 0; j < poles; ++j) {
    const std::string pole = "pole[" + std::to_string(j + 1) + "].";
    t.add(Kind::bridge_travel, out, pole + "bridge_position", "m",
          "travel of the bridge from its open position", 0, j);
    t.add(Kind::force_a, out, pole + "force_a", "N", "contact force at break A", 0, j);
    t.add(Kind::force_b, out, pole + "force_b", "N", "contact force at break B", 0, j);
    t.add(Kind::closed, out, pole + "closed", "", "both breaks of the pole touch", 0, j);
    t.add(Kind::touch_time, out, pole + "touch_time", "s",
          "both breaks closed for the first time; -1 before it", 0, j);
  }
}

}  // namespace

std::vector<Variable> variables(const sim::Specimen& specimen, Fmi fmi) {
  Table t;
  t.add(Kind::time, Causality::independent, "time", "s", "simulation time");
  const auto in = Causality::input, parameter = Causality::parameter;
  t.add(Kind::coil_voltage, in, "coil_voltage", "V",
        "voltage at the coil terminals, without the own source's");
  if (fmi == Fmi::three)
    t.add(Kind::coil_voltage_rate, in, "coil_voltage_rate", "V/s",
          "slope of coil_voltage over the next communication step; 0: it is held");
  t.add(Kind::coil_temperature, in, "coil_temperature", "K", "temperature of the winding, for its resistance",
        293.15);
  t.add(Kind::coil_closed, in, "coil_closed", "",
        "the coil circuit is closed; opened, the current ends at its next zero", 1);
  add_outputs(t, specimen.bridges.poles);
  const UnitSettings usual;
  t.add(Kind::source_volts, parameter, "source.volts", "V",
        "own sine in series with coil_voltage, root mean square; 0: none", usual.source_volts);
  t.add(Kind::source_hertz, parameter, "source.hertz", "Hz", "frequency of the own sine", usual.source_hertz);
  t.add(Kind::source_phase, parameter, "source.phase", "rad", "phase of the own sine at time 0",
        usual.source_phase);
  t.add(Kind::tolerance, parameter, "tolerance", "1", "relative tolerance of the integrator in co-simulation",
        usual.tolerance);
  int index = 0;
  for (const auto& f : sim::specimen_fields()) {
    if (may_be_set(f))
      t.add(Kind::number, parameter, std::string(f.section) + "." + std::string(f.key), unit_of_key(f.key),
            std::string(f.meaning), f.get(specimen) / f.si_per_unit, index);
    ++index;
  }
  if (fmi == Fmi::three) return std::move(t.rows);
  const auto states = state_names(specimen);
  for (std::size_t k = 0; k < states.size(); ++k)
    t.add(Kind::state, Causality::local, "state." + states[k].name, states[k].unit,
          "state for model exchange", 0, static_cast<int>(k));
  for (std::size_t k = 0; k < states.size(); ++k)
    t.add(Kind::rate, Causality::local, "der(state." + states[k].name + ")", states[k].rate_unit,
          "its derivative by time", 0, static_cast<int>(k));
  return std::move(t.rows);
}

const std::vector<UnitRow>& unit_rows() {
  static const std::vector<UnitRow> rows{
      {"1", 0, 0, 0, 0, 0, 0, 1},      {"s", 0, 0, 1, 0, 0, 0, 1},         {"Hz", 0, 0, -1, 0, 0, 0, 1},
      {"rad", 0, 0, 0, 0, 0, 1, 1},    {"rad/s", 0, 0, -1, 0, 0, 1, 1},    {"rad/s2", 0, 0, -2, 0, 0, 1, 1},
      {"m", 0, 1, 0, 0, 0, 0, 1},      {"mm", 0, 1, 0, 0, 0, 0, 1e-3},     {"um", 0, 1, 0, 0, 0, 0, 1e-6},
      {"mm2", 0, 2, 0, 0, 0, 0, 1e-6}, {"m/s", 0, 1, -1, 0, 0, 0, 1},      {"m/s2", 0, 1, -2, 0, 0, 0, 1},
      {"g", 1, 0, 0, 0, 0, 0, 1e-3},   {"g.mm2", 1, 2, 0, 0, 0, 0, 1e-9},  {"N", 1, 1, -2, 0, 0, 0, 1},
      {"N/m", 1, 0, -2, 0, 0, 0, 1},   {"A", 0, 0, 0, 1, 0, 0, 1},         {"A/s", 0, 0, -1, 1, 0, 0, 1},
      {"A/m", 0, -1, 0, 1, 0, 0, 1},   {"A/(m.T)", -1, -1, 2, 2, 0, 0, 1}, {"V", 1, 2, -3, -1, 0, 0, 1},
      {"V/s", 1, 2, -4, -1, 0, 0, 1},  {"Wb", 1, 2, -2, -1, 0, 0, 1},      {"T", 1, 0, -2, -1, 0, 0, 1},
      {"H", 1, 2, -2, -2, 0, 0, 1},    {"ohm", 1, 2, -3, -2, 0, 0, 1},     {"K", 0, 0, 0, 0, 1, 0, 1},
      {"1/K", 0, 0, 0, 0, -1, 0, 1},
  };
  return rows;
}

}  // namespace powbench::fmu
