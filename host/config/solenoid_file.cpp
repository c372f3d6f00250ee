#include "host/config/solenoid_file.h"

#include <fstream>
#include <stdexcept>

#include "host/config/file_reader.h"
#include "host/config/steel_file.h"

namespace powbench::host {
namespace {

/// What the file holds as text, beside the numbers.
struct SolenoidWords {
  std::string steel;
  int kind = 0;
};

void add_shape(FileKind& kind, sim::SolenoidDesign& d) {
  auto& s = d.shape;
  const auto length = [&](const char* key, double& value, const char* meaning) {
    kind.number(key, value, {0.05, 500}, meaning);
  };
  kind.section("shape", "half section beside the axis; see docs/how-to/solenoid.md for the drawing");
  length("plunger_radius_mm", s.plunger_radius, "R, of plunger and stop");
  length("bore_radius_mm", s.bore_radius, "of the flange that the plunger slides through");
  length("plunger_length_mm", s.plunger_length, "from the rim of its face");
  length("stop_length_mm", s.stop_length, "from the plate to the rim of the stop's face");
  length("window_mm", s.window, "from the plate to the flange");
  length("plate_mm", s.plate, "thickness, at the stop");
  length("flange_mm", s.flange, "thickness, at the plunger");
  length("coil_inner_mm", s.coil_inner, "inner radius of the winding");
  length("coil_outer_mm", s.coil_outer, "outer radius of the winding");
  length("coil_clearance_mm", s.coil_clearance, "of the winding to plate and flange");
  length("case_inner_mm", s.case_inner, "inner radius of the case");
  length("case_outer_mm", s.case_outer, "outer radius of the case");
  kind.choice("face", s.face, {"flat", "conical", "stepped"}, "of plunger and stop");
  kind.number("cone_angle_deg", s.cone_angle, {0, 75}, "conical: slope of the face, 0 would be flat");
  kind.number("tip_radius_mm", s.tip_radius, {0, 500}, "conical: of the flat end; 0: a point");
  kind.number("step_radius_mm", s.step_radius, {0, 500}, "stepped: of the pin");
  kind.number("step_depth_mm", s.step_depth, {0, 500}, "stepped: of pin and hole");
  kind.number("step_clearance_mm", s.step_clearance, {0, 500}, "stepped: radial, between pin and hole");
}

FileKind kind_of(sim::SolenoidSpecimen& s, SolenoidWords& words) {
  FileKind kind("solenoid", "one solenoid, as the simulator sees it");
  kind.choice("kind", words.kind, {"solenoid"},
              "of this specimen; without it the file is that of a contactor");
  kind.text("name", s.name, "name of the solenoid");
  add_shape(kind, s.design);
  kind.number("magnet_length_mm", s.design.shape.magnet_length, {0, 500},
              "of a permanent magnet: the lower end of the stop, over its whole radius; 0: none");
  kind.section("magnet", "steel, gaps, permanent magnet");
  kind.text(
      "steel", words.steel,
      "a B-H sheet (CSV, its place as seen from this file) or a built-in steel; `powbench steel` lists them");
  auto& d = s.design;
  kind.number("residual_gap_um", d.residual_gap, {1, 1000}, "at the stop when closed");
  kind.number("travel_mm", d.largest_gap, {0.1, 500}, "of the plunger");
  kind.number("conductivity_S_per_m", s.conductivity, {0, 1e8},
              "of plunger, stop, plate, flange and case, for --fields eddy; 0: no eddy currents");
  kind.number("remanence_T", d.remanence, {-2, 2},
              "of the permanent magnet; above 0: along the flux of the coil's current, below: against it");
  kind.number("magnet_permeability", d.magnet_permeability, {1, 10}, "of the permanent magnet, relative");
  kind.section("coil", "u = R i + d psi/dt");
  kind.number("turns", s.design.turns, {1, 1e6}, "N");
  kind.number("resistance_ohm", s.coil.resistance, {1e-4, 1e6}, "R at 20 degC");
  kind.number("temperature_coefficient_per_K", s.coil.temperature_coefficient, {0, 0.01},
              "alpha of the resistance");
  kind.number("hold_turns", s.coil.hold_turns, {0, 1e6},
              "economiser: of a hold winding, in series once the contact has changed over; 0: none");
  kind.number("hold_resistance_ohm", s.coil.hold_resistance, {0, 1e6}, "of the hold winding at 20 degC");
  kind.number("hold_from_mm", s.coil.hold_from, {0, 500}, "travel at which the contact changes over");
  kind.section("plunger", "moving parts, spring, load and stops");
  auto& p = s.plunger;
  kind.number("mass_g", p.mass, {0.01, 1e5}, "of the plunger");
  kind.number("load_mass_g", p.load_mass, {0, 1e6}, "moved by the plunger");
  kind.number("return_preload_N", p.return_preload, {0, 1e5}, "spring, open");
  kind.number("return_rate_N_per_m", p.return_rate, {0, 1e7}, "spring");
  kind.number("load_N", p.load, {-1e5, 1e5}, "constant, against the closing; weight is one");
  kind.number("friction_N", p.friction, {0, 1e5}, "Coulomb friction");
  kind.number("stop_stiffness_N_per_m", p.stop_stiffness, {1e3, 1e10}, "of both stops");
  kind.number("stop_restitution", p.stop_restitution, {0.01, 1}, "rebound over approach speed at both stops");
  return kind;
}

/// Section and key of a sentence that begins with `section.key = `; "solenoid." stands for the shape.
void place_error(FileReader& reader, const std::string& sentence) {
  const auto dot = sentence.find('.'), equals = sentence.find(" = ");
  if (dot == std::string::npos || equals == std::string::npos || dot > equals) {
    reader.fail("", "kind", sentence);
    return;
  }
  std::string section = sentence.substr(0, dot), key = sentence.substr(dot + 1, equals - dot - 1);
  if (section == "solenoid") section = "shape";
  if (key == "remanence_T" || key == "magnet_permeability" || key == "residual_gap_um") section = "magnet";
  if (key == "turns") section = "coil";
  if (key == "gap_mm") section = "magnet", key = "travel_mm";
  if (key == "cone_depth_mm") key = "cone_angle_deg";
  const auto allowed = sentence.find(", allowed ");
  reader.fail(section, key,
              reader.good(section, key)
                  ? "does not go with the other numbers"
                  : "is left out, and " + sentence.substr(equals + 3, allowed - equals - 3) +
                        " does not go with the other numbers",
              allowed == std::string::npos ? "" : sentence.substr(allowed + 10));
}

sim::SolenoidSpecimen read_with(FileReader reader, const std::filesystem::path& folder) {
  sim::SolenoidSpecimen s;
  SolenoidWords words{s.design.steel.name()};
  const auto kind = kind_of(s, words);
  reader.read(kind);
  bool all_good = true;
  for (const auto& f : kind.fields()) all_good = all_good && !reader.bad(f.section, f.key);
  if (reader.good("magnet", "steel")) try {
      s.design.steel = names_steel_file(words.steel)
                           ? sim::Steel::table(read_steel(folder / words.steel).name,
                                               read_steel(folder / words.steel).fitted.rows)
                           : sim::builtin_steel(words.steel);
    } catch (const BadInput& error) {
      for (const auto& line : error.errors()) reader.fail("magnet", "steel", line);
    } catch (const std::invalid_argument& error) {
      reader.fail("magnet", "steel", error.what());
    }
  if (all_good) try {
      sim::require_valid(s);
    } catch (const std::invalid_argument& error) {
      place_error(reader, error.what());
    }
  reader.finish();
  return s;
}

}  // namespace

bool is_solenoid_file(const std::filesystem::path& path) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    std::string packed;
    for (const char c : line.substr(0, line.find('#')))
      if (c != ' ' && c != '\t' && c != '\r') packed += c == '\'' ? '"' : c;
    if (packed.starts_with("[")) return false;
    if (packed.starts_with("kind=")) return packed != "kind=\"contactor\"";
  }
  return false;
}

void refuse_solenoid(const std::filesystem::path& path) {
  if (is_solenoid_file(path))
    throw BadInput({path.string() +
                    ": kind = \"solenoid\", allowed \"contactor\" here; `powbench sim`, `powbench field` and "
                    "`powbench specimen describe` take solenoids"});
}

sim::SolenoidSpecimen read_solenoid(const std::filesystem::path& path) {
  return read_with(FileReader::open(path), path.parent_path());
}

std::string solenoid_template() {
  sim::SolenoidSpecimen s;
  SolenoidWords words{s.design.steel.name()};
  auto kind = kind_of(s, words);
  for (auto& f : kind.fields())
    if (f.key == "kind") f.need = Need::required;
  return kind.template_text();
}

}  // namespace powbench::host
