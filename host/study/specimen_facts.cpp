#include "host/study/specimen_facts.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/units.h"
#include "sim/mechanics/contact_damping.h"
#include "sim/models/closing.h"
#include "sim/study/parameter.h"
#include "sim/study/steady.h"
#include "sim/study/voltage_limits.h"

namespace powbench::host {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

double hertz_of(double rate, double mass) {
  return std::sqrt(rate / mass) / (2 * pi);
}

/// Half a period of the damped oscillation of a contact that a mass meets, s: about how long one impact lasts.
double impact_time(double stiffness, double mass) {
  return pi * std::sqrt(mass / stiffness);
}

void add_electric(const sim::Specimen& s, const Conditions& rated, std::vector<SpecimenFact>& facts) {
  const auto mains = sim::closing_mains(rated);
  const auto safe = [&](const std::string& name, const std::string& key, double low, double high,
                        const std::function<double()>& of) {
    SpecimenFact f{name, key, none, low, high, ""};
    try {
      f.value = of();
    } catch (const std::exception& e) {
      f.note = e.what();
    }
    facts.push_back(f);
  };
  const double u = rated.supply_volts;
  safe("inrush, VA", "inrush_VA", 70, 230, [&] { return sim::inrush_power(s, mains); });
  safe("holding, VA", "holding_VA", 7, 32, [&] { return sim::holding_power(s, mains); });
  safe("picks up at, V", "pick_up_V", none, 0.85 * u, [&] { return sim::pick_up_volts(s, rated); });
  safe("drops out at, V", "drop_out_V", 0.2 * u, 0.75 * u, [&] { return sim::drop_out_volts(s, rated); });
  safe("least pull closed, N", "least_pull_N", sim::closed_load(s), none,
       [&] { return sim::least_pull(s, mains); });
}

void add_motion(const sim::Specimen& s, std::vector<SpecimenFact>& facts) {
  const auto& b = s.bridges;
  const double core = s.core.return_rate, housing = s.base.mass;
  const auto add = [&](const char* name, const char* key, double value, double low = none,
                       double high = none) {
    facts.push_back({name, key, value, low, high, ""});
  };
  add("load closed, N", "closed_load_N", sim::closed_load(s));
  add("contact force of one break, N", "break_force_N", 0.5 * (b.preload + b.rate * (s.core.travel - b.gap)),
      1.5, 5);
  add("core on its return spring, Hz", "core_Hz", hertz_of(core, s.core.mass));
  add("core with pressed contacts, Hz", "core_closed_Hz", hertz_of(core + b.poles * b.rate, s.core.mass));
  add("bridge on its spring, Hz", "bridge_Hz", hertz_of(b.rate, b.mass));
  add("bridge on its seat, Hz", "seat_Hz", hertz_of(b.seat_stiffness, sim::seat_mass(s)));
  add("base on its mounting, Hz", "base_Hz", s.base.hertz);
  if (s.base.core_mass > 0) {
    add("static core on its buffer, Hz", "buffer_Hz", s.base.core_hertz);
    add("static core against free housing, Hz", "buffer_free_Hz",
        s.base.core_hertz * std::sqrt(1 + s.base.core_mass / housing));
  }
  if (s.core.tilt_inertia > 0) add("tilt of the core, Hz", "tilt_Hz", s.core.tilt_hertz);
  constexpr double of_first[] = {1, 2.756538, 5.403918};
  for (int k = 0; k < s.base.flex_modes; ++k)
    facts.push_back({fmt::format("bending mode {} of the housing, Hz", k + 1),
                     fmt::format("flex_{}_Hz", k + 1), s.base.flex_hertz * of_first[k], none, none, ""});
  add("impact of contacts lasts, us", "contact_impact_us",
      1e6 * impact_time(b.contact_stiffness, sim::pad_mass(s)));
  add("impact of the core lasts, us", "stop_impact_us",
      1e6 * impact_time(s.core.stop_stiffness, sim::stop_mass(s)));
  const auto bound = [](std::string_view key) {
    for (const auto& p : sim::catalogue_parameters())
      if (p.name() == key) return std::pair{p.low, p.high};
    return std::pair{none, none};
  };
  const auto pad = bound("bridges.contact_restitution"), stop = bound("core.stop_restitution");
  add("contacts rebound with, of the speed", "contact_rebound", b.contact_restitution, pad.first, pad.second);
  add("core rebounds with, of the speed", "stop_rebound", s.core.stop_restitution, stop.first, stop.second);
}

/// What a number outside the range of its kind may stand for where it is no slip; "" where nothing is known.
std::string meaning(std::string_view key, bool below) {
  struct Meaning {
    std::string_view key;
    bool below;
    const char* text;
  };
  constexpr Meaning list[] = {
      {"core.travel_mm", true, "another magnet than that of this frame, whose core moves 3.82 mm or more"},
      {"core.friction_N", false, "a holder that jams, or guides under side load"},
      {"bridges.rate_N_per_m", true, "a long soft overtravel spring; the preload makes the contact force"},
      {"bridges.contact_stiffness_N_per_m", true,
       "softer than metal on metal: a sensor film or a pad at the contacts"},
      {"bridges.seat_stiffness_N_per_m", true,
       "softer than metal on plastic: a pad or a thin web under the bridge"},
      {"bridges.seat_damping", false, "hardly an oscillation: the bridge lands in a pad or in friction"},
      {"base.mass_g", false,
       "more than the static core and its housing: the plate of the mounting moves too"},
      {"base.damping", false, "rubber under the base or a loose mounting, no rail"},
  };
  for (const Meaning& m : list)
    if (m.key == key && m.below == below) return m.text;
  return "";
}

/// Keys of the file that no catalogue and no plausibility allows: most are a slip of unit or of a digit.
void add_outside(const sim::Specimen& s, std::vector<SpecimenFact>& facts) {
  for (const auto& p : sim::catalogue_parameters(s.base.core_mass > 0)) {
    const double unit = p.field->si_per_unit, value = p.field->get(s);
    if (value < p.low || value > p.high)
      facts.push_back(
          {p.name(), p.name(), value / unit, p.low / unit, p.high / unit, meaning(p.name(), value < p.low)});
  }
}

std::string range_text(double low, double high) {
  if (std::isnan(low) && std::isnan(high)) return "-";
  if (std::isnan(low)) return fmt::format("up to {:.4g}", high);
  return std::isnan(high) ? fmt::format("from {:.4g}", low) : fmt::format("{:.4g} .. {:.4g}", low, high);
}

std::string verdict(const SpecimenFact& f) {
  if (std::isnan(f.value)) return "not known";
  if (std::isnan(f.low) && std::isnan(f.high)) return "";
  return f.value < f.low || f.value > f.high ? "outside" : "inside";
}

nlohmann::ordered_json or_null(double v) {
  return std::isfinite(v) ? nlohmann::ordered_json(v) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::vector<SpecimenFact> specimen_facts(const sim::Specimen& s, const Conditions& rated) {
  std::vector<SpecimenFact> facts;
  add_electric(s, rated, facts);
  add_motion(s, facts);
  add_outside(s, facts);
  return facts;
}

std::string facts_text(const sim::Specimen& s, const Conditions& rated,
                       const std::vector<SpecimenFact>& facts) {
  std::string out =
      fmt::format("specimen '{}' at {:g} V, {:g} Hz, coil at 20 degC\n{:<38} {:>12} {:>20}  {}\n", s.name,
                  rated.supply_volts, rated.mains_hertz, "", "value", "catalogues", "");
  for (const auto& f : facts)
    out += fmt::format("{:<38} {:>12} {:>20}  {}{}\n", f.name,
                       std::isnan(f.value) ? std::string("-") : fmt::format("{:.4g}", f.value),
                       range_text(f.low, f.high), verdict(f), f.note.empty() ? "" : ": " + f.note);
  return out +
         "catalogues: three-pole contactors of the 25 .. 40 A frame. Frequencies: each body on its own "
         "spring, the others at "
         "rest, but for the bridge on its seat and for impacts: those with the reduced mass of both.\n"
         "Powers, voltages and pull: of the circuit in [magnet]; [shape] is not used. `powbench specimen "
         "circuit` derives the "
         "one from the other.\n"
         "Outside: a slip of unit or digit, or another kind of device; then the text behind it says what it "
         "may be.\n";
}

std::string facts_json(const sim::Specimen& s, const std::vector<SpecimenFact>& facts) {
  nlohmann::ordered_json list = nlohmann::ordered_json::object();
  for (const auto& f : facts)
    list[f.key] = {{"value", or_null(f.value)},
                   {"catalogue_low", or_null(f.low)},
                   {"catalogue_high", or_null(f.high)},
                   {"verdict", verdict(f).empty() ? nlohmann::ordered_json(nullptr)
                                                  : nlohmann::ordered_json(verdict(f))},
                   {"note", f.note}};
  return nlohmann::ordered_json{{"specimen", s.name}, {"numbers", list}}.dump(2) + "\n";
}

}  // namespace powbench::host
