#include "host/config/specimen_file.h"

#include <stdexcept>

#include "host/config/file_reader.h"
#include "host/config/steel_file.h"
#include "sim/specimen_fields.h"
#include "sim/specimen_steel.h"
#include "sim/validate.h"

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

bool is_law_key(std::string_view key) {
  return key.starts_with("bh_");
}

/// The measured steel of a magnet. Its rows are written only where there are any: a file names a sheet, a stored specimen holds
/// what was in it.
void add_steel(FileKind& kind, sim::Magnet& m, bool reading) {
  kind.text(
      "steel", m.steel,
      "a measured steel in place of the law H = a B + b B^n: a B-H sheet (CSV, its place as seen from this "
      "file) or a built-in one; `powbench steel` lists them");
  if (!reading && m.steel_b.empty()) return;
  kind.sweep("steel_B_T", m.steel_b, {0, 100}, "flux densities of the steel's rows, in place of a sheet",
             Need::defaulted);
  kind.sweep("steel_H_A_per_m", m.steel_h, {0, 1e8}, "field strengths of the steel's rows", Need::defaulted);
}

/// The simulator's own table of specimen fields, as a file. A shape that is not known is left out of what is written.
FileKind kind_of(sim::Specimen& s, bool reading = false) {
  FileKind kind("specimen", "one contactor, as the simulator sees it");
  kind.text("name", s.name, "name of the contactor, stored with every shot");
  for (const auto& f : sim::specimen_fields()) {
    const std::string section(f.section);
    if (section == "shape" && !s.shaped && !reading) break;  // the last section
    if (kind.sections().back().name != section) {
      kind.section(section, meaning_of(section));
      if (section == "magnet") add_steel(kind, s.magnet, reading);
    }
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

sim::Specimen read_with(FileReader reader, const std::filesystem::path& folder) {
  sim::Specimen s;
  s.shaped = false;
  reader.read(kind_of(s, true));
  load_steel(reader, s.magnet, folder);
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
  return read_with(FileReader::open(path), path.parent_path());
}

sim::Specimen parse_specimen(std::string text, std::string file) {
  const auto folder = std::filesystem::path(file).parent_path();
  return read_with(FileReader(std::move(file), std::move(text)), folder);
}

std::string specimen_template() {
  sim::Specimen s;
  return kind_of(s).template_text();
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
