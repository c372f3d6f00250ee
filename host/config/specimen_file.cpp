#include "host/config/specimen_file.h"

#include "host/config/file_reader.h"
#include "sim/specimen_fields.h"
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

/// The simulator's own table of specimen fields, as a file. A shape that is not known is left out of what is written.
FileKind kind_of(sim::Specimen& s, bool reading = false) {
  FileKind kind("specimen", "one contactor, as the simulator sees it");
  kind.text("name", s.name, "name of the contactor, stored with every shot");
  for (const auto& f : sim::specimen_fields()) {
    const std::string section(f.section);
    if (section == "shape" && !s.shaped && !reading) break;  // the last section
    if (kind.sections().back().name != section) kind.section(section, meaning_of(section));
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

sim::Specimen read_with(FileReader reader) {
  sim::Specimen s;
  s.shaped = false;
  reader.read(kind_of(s, true));
  bool lengths_known = !reader.bad("core", "travel_mm");
  for (const char* key : {"gap_mm", "tilt_gap_mm", "gap_spread_mm"})
    lengths_known = lengths_known && !reader.bad("bridges", key);
  // read() checked single values: what is left are lengths that do not fit together
  for (const auto& error : sim::validate(s)) {
    const auto dot = error.key.find('.');
    if (lengths_known)
      reader.fail(error.key.substr(0, dot), error.key.substr(dot + 1),
                  "does not fit the other lengths: " + error.value, error.range);
  }
  reader.finish();
  return s;
}

}  // namespace

sim::Specimen read_specimen(const std::filesystem::path& path) {
  return read_with(FileReader::open(path));
}

sim::Specimen parse_specimen(std::string text, std::string file) {
  return read_with(FileReader(std::move(file), std::move(text)));
}

std::string specimen_template() {
  sim::Specimen s;
  return kind_of(s).template_text();
}

std::string resolved_text(const sim::Specimen& specimen) {
  sim::Specimen s = specimen;
  return kind_of(s).resolved_text();
}

}  // namespace powbench::host
