#include "host/config/specimen_file.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "host/config/drawing_file.h"
#include "host/config/file_reader.h"
#include "host/config/solenoid_file.h"
#include "host/config/space_file.h"
#include "host/config/steel_file.h"
#include "sim/magnetics/circuit/lumped_magnet.h"
#include "sim/specimen/specimen_fields.h"
#include "sim/specimen/validate.h"

namespace powbench::host {
namespace {

std::string meaning_of(std::string_view section) {
  if (section == "coil") return "coil: u = R i + d psi/dt";
  if (section == "magnet")
    return "magnetic circuit: two parallel pole faces, one of them inside the shading ring";
  if (section == "core") return "moving core with its holder, return spring and stop";
  if (section == "bridges")
    return "contact bridges with overtravel springs; forces, rates and masses of one bridge";
  if (section == "base") return "static core and fixed contacts as one floating mass on the mounting";
  if (section == "shape")
    return "the laminated core seen from the side, for the field rungs; left out: unknown, and there are "
           "none";
  return std::string(section);
}

/// What a kind is made for: reading a file, writing the values of a specimen, or a template with every key.
enum class Writes { nothing, values, all };

bool is_law_key(std::string_view key) {
  return key.starts_with("bh_");
}

bool is_circuit_key(std::string_view section, std::string_view key) {
  if (section == "coil") return key == "leakage_H";
  return section == "magnet" && (is_law_key(key) || key == "pole_area_mm2" || key == "iron_length_mm" ||
                                 key == "fringing" || key == "shaded_share");
}

/// The drawing of a magnet. A file names it, a stored specimen holds the hash of what was in it, too.
void add_drawing(FileKind& kind, sim::Magnet& m, Writes writes) {
  if (writes == Writes::values && m.drawing.empty()) return;
  kind.text("drawing", m.drawing,
            "a drawing file (x.magnet.toml, its place as seen from this file) in place of [shape]: its table "
            "is the "
            "magnet; turns, travel_mm, residual_gap_um and the ring's resistance are the drawing's");
  if (writes == Writes::all) return;
  kind.text("drawing_hash", m.drawing_hash, "of what was in the drawing; written into stored specimens");
}

/// The measured steel of a magnet. Its rows are written only where there are any: a file names a sheet, a stored
/// specimen holds what was in it.
void add_steel(FileKind& kind, sim::Magnet& m, Writes writes) {
  kind.text(
      "steel", m.steel,
      "a measured steel in place of the law H = a B + b B^n: a B-H sheet (CSV, its place as seen from this "
      "file) or a built-in one; `powbench steel` lists them");
  if (writes != Writes::nothing && m.steel_b.empty()) return;
  kind.sweep("steel_B_T", m.steel_b, {0, 100}, "flux densities of the steel's rows, in place of a sheet",
             Need::defaulted);
  kind.sweep("steel_H_A_per_m", m.steel_h, {0, 1e8}, "field strengths of the steel's rows", Need::defaulted);
}

/// The simulator's own table of specimen fields, as a file. A shape that is not known is left out of what is written.
FileKind kind_of(sim::Specimen& s, Writes writes = Writes::values) {
  const bool reading = writes == Writes::nothing;
  FileKind kind("specimen", "one contactor, as the simulator sees it");
  kind.text("name", s.name, "name of the contactor, stored with every shot");
  for (const auto& f : sim::specimen_fields()) {
    const std::string section(f.section);
    if (section == "shape" && !s.shaped && !reading) break;  // the last section
    if (kind.sections().back().name != section) {
      kind.section(section, meaning_of(section));
      if (section == "magnet") {
        add_drawing(kind, s.magnet, writes);
        add_steel(kind, s.magnet, writes);
      }
    }
    if (!s.lumped && !reading && is_circuit_key(section, f.key)) continue;
    if (is_law_key(f.key) && !s.magnet.steel.empty() && !reading) continue;
    const bool drawn = section == "shape";
    kind.number(std::string(f.key),
                {[&s, &f] { return f.get(s); },
                 [&s, &f, drawn](double v) {
                   f.set(s, v);
                   s.shaped = s.shaped || drawn;
                 },
                 f.whole},
                {f.low, f.high}, std::string(f.meaning));
  }
  return kind;
}

/// Reads the sheet that the magnet names, or looks its steel up; every mistake is one of `reader`.
void load_steel(FileReader& reader, sim::Magnet& m, const std::filesystem::path& folder) {
  if (!reader.good("magnet", "steel")) {
    for (const char* key : {"steel_B_T", "steel_H_A_per_m"})
      if (reader.good("magnet", key))
        reader.fail("magnet", key, "belongs to a steel: give its name as `steel`");
    return;
  }
  for (const auto& f : sim::specimen_fields())
    if (is_law_key(f.key) && reader.good("magnet", f.key))
      reader.fail("magnet", f.key, "is the law that `steel` stands in for: leave out one of both");
  if (reader.bad("magnet", "steel_B_T") || reader.bad("magnet", "steel_H_A_per_m")) return;
  try {
    if (m.steel_b.empty() && m.steel_h.empty() && names_steel_file(m.steel)) {
      const auto sheet = read_steel(folder / m.steel);
      m.steel = sheet.name;
      for (const auto& row : sheet.fitted.rows) {
        m.steel_b.push_back(row.b);
        m.steel_h.push_back(row.h);
      }
    }
    static_cast<void>(sim::steel_of(m));
  } catch (const BadInput& error) {
    for (const auto& line : error.errors()) reader.fail("magnet", "steel", line);
  } catch (const std::invalid_argument& error) {
    reader.fail("magnet", "steel", error.what());
  }
}

/// A number that the drawing gives, too: the file may leave it out, or state the same.
void take_number(FileReader& reader, std::string_view section, std::string_view key, double& value,
                 double drawn) {
  if (reader.bad(section, key)) return;
  if (reader.good(section, key) && std::fabs(value - drawn) > 1e-6 * std::fabs(drawn))
    reader.fail(section, key, "the drawing has another value: leave one out");
  value = drawn;
}

/// What the specimen takes from its drawing.
template <class Drawing>
void take_drawing(FileReader& reader, sim::Specimen& s, const Drawing& d) {
  char hash[20];
  std::snprintf(hash, sizeof hash, "%016" PRIx64, sim::drawing_hash(d));
  s.magnet.drawing_hash = hash;
  take_number(reader, "coil", "turns", s.coil.turns, d.turns());
  take_number(reader, "core", "travel_mm", s.core.travel, d.travel);
  take_number(reader, "magnet", "residual_gap_um", s.magnet.residual_gap, d.residual_gap);
  if (d.ring_resistance > 0)
    take_number(reader, "magnet", "ring_resistance_ohm", s.magnet.ring_resistance, d.ring_resistance);
}

/// Reads the drawing that the magnet names; every mistake is one of `reader`.
void load_drawing(FileReader& reader, sim::Specimen& s, const std::filesystem::path& folder) {
  const auto stated = [&](std::string_view section, std::string_view key) {
    return reader.good(section, key);
  };
  if (!stated("magnet", "drawing")) {
    if (stated("magnet", "drawing_hash")) reader.fail("magnet", "drawing_hash", "belongs to a drawing");
    return;
  }
  if (s.shaped) reader.fail("magnet", "drawing", "[shape] is another magnet: leave out one of both");
  s.lumped = stated("magnet", "pole_area_mm2") && stated("magnet", "iron_length_mm");
  if (!s.lumped)
    for (const auto& f : sim::specimen_fields())
      if (is_circuit_key(f.section, f.key) && stated(f.section, f.key))
        reader.fail(f.section, f.key,
                    "is of a lumped circuit, which a drawn magnet has only where pole_area_mm2 and "
                    "iron_length_mm are "
                    "given");
  if (stated("magnet", "drawing_hash")) return;  // a stored specimen: its mesh is elsewhere
  if (!s.lumped && stated("magnet", "steel"))
    reader.fail("magnet", "steel", "does not go with a drawing, whose groups name their steels");
  try {
    const auto file = folder / s.magnet.drawing;
    if (is_space_drawing(file))
      s.in_space = read_space_drawing(file);
    else
      s.drawn = read_drawing(file);
  } catch (const BadInput& error) {
    for (const auto& line : error.errors()) reader.fail("magnet", "drawing", line);
    return;
  }
  if (s.in_space)
    take_drawing(reader, s, *s.in_space);
  else
    take_drawing(reader, s, *s.drawn);
}

sim::Specimen read_with(FileReader reader, const std::filesystem::path& folder) {
  sim::Specimen s;
  s.shaped = false;
  reader.read(kind_of(s, Writes::nothing));
  load_steel(reader, s.magnet, folder);
  load_drawing(reader, s, folder);
  bool lengths_known = !reader.bad("core", "travel_mm");
  for (const char* key : {"gap_mm", "tilt_gap_mm", "gap_spread_mm"})
    lengths_known = lengths_known && !reader.bad("bridges", key);
  // read() checked single values: what is left are lengths that do not fit together, and exponents between the laws
  for (const auto& error : sim::validate(s)) {
    const auto dot = error.key.find('.');
    const bool exponent = error.key.ends_with("_exponent");
    if (exponent || lengths_known)
      reader.fail(error.key.substr(0, dot), error.key.substr(dot + 1),
                  (exponent ? "no contact law has this exponent: " : "does not fit the other lengths: ") +
                      error.value,
                  error.range);
  }
  reader.finish();
  return s;
}

}  // namespace

sim::Specimen read_specimen(const std::filesystem::path& path) {
  refuse_solenoid(path);
  return read_with(FileReader::open(path), path.parent_path());
}

sim::Specimen parse_specimen(std::string text, std::string file) {
  const auto folder = std::filesystem::path(file).parent_path();
  return read_with(FileReader(std::move(file), std::move(text)), folder);
}

std::string specimen_template() {
  sim::Specimen s;
  return kind_of(s, Writes::all).template_text();
}

std::vector<KeyLine> keys_of(const sim::Specimen& specimen) {
  sim::Specimen s = specimen;
  return kind_of(s).lines();
}

std::string resolved_text(const sim::Specimen& specimen) {
  sim::Specimen s = specimen;
  return kind_of(s).resolved_text();
}

}  // namespace powbench::host
