#include "host/config/drawing_parts.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "host/config/steel_file.h"

namespace powbench::host {
namespace {

namespace fs = std::filesystem;

std::string drawing_bytes(const fs::path& path) {
  if (fs::is_directory(path)) throw std::invalid_argument(path.string() + " is a folder");
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  if (!in) throw std::invalid_argument(path.string() + " cannot be read");
  return text.str();
}

/// The file with nothing but the line of its mesh, for a sentence about that line alone.
FileReader only_mesh(const fs::path& path) {
  std::istringstream in(drawing_bytes(path));
  std::string text;
  for (std::string line; std::getline(in, line);) text += (line.starts_with("mesh") ? line : "") + "\n";
  return {path.string(), text};
}

/// Throws BadInput or std::invalid_argument.
sim::Steel steel_of_drawing(const fs::path& folder, const std::string& name) {
  if (!names_steel_file(name)) return sim::builtin_steel(name);
  const auto sheet = read_steel(folder / name);
  return sim::Steel::table(sheet.name, sheet.fitted.rows);
}

}  // namespace

sim::MshMesh mesh_of_drawing(const fs::path& file, const std::string& mesh) {
  try {
    return sim::read_msh(drawing_bytes(file.parent_path() / mesh));
  } catch (const std::invalid_argument& error) {
    DrawingDraft draft;
    FileReader alone = only_mesh(file);
    alone.read(mesh_key(draft));
    alone.fail("", "mesh", error.what());
    alone.finish();
    throw;
  }
}

int DrawnSteels::index(const std::string& section, const std::string& name, double stack_factor,
                       std::vector<sim::Steel>& list) {
  if (reader_.bad(section, "steel")) return -1;
  if (name.empty()) {
    reader_.fail(section, "steel", "is missing",
                 "a built-in steel (`powbench steel` lists them) or a B-H sheet");
    return -1;
  }
  if (const auto known = known_.find(name); known != known_.end()) return known->second;
  try {
    const sim::Steel steel = steel_of_drawing(folder_, name);
    list.push_back(stack_factor == 1 ? steel : steel.stacked(stack_factor));
  } catch (const BadInput& error) {
    for (const auto& line : error.errors()) reader_.fail(section, "steel", line);
    return -1;
  } catch (const std::invalid_argument& error) {
    reader_.fail(section, "steel", error.what());
    return -1;
  }
  return known_[name] = static_cast<int>(list.size()) - 1;
}

std::string better_unit(DrawnUnit unit, double length, double low, double high) {
  for (std::size_t k = 0; k < drawn_units.size(); ++k) {
    const double other = length / drawn_metres[static_cast<int>(unit)] * drawn_metres[k];
    if (other >= low && other <= high)
      return fmt::format("; in {} it would be {:.4g} mm", drawn_units[k], other * 1e3);
  }
  return "";
}

void check_drawn_size(FileReader& reader, DrawnUnit unit, double extent, double gap, double drawn_gap) {
  if (!(extent >= 10e-3 && extent <= 3)) {
    reader.fail("", "unit",
                fmt::format("the mesh is {:.4g} mm wide or high{}", extent * 1e3,
                            better_unit(unit, extent, 10e-3, 3)),
                "10..3000 mm");
    return;
  }
  if (std::isinf(gap)) {
    reader.fail("", "opening",
                "below the armature, against this direction, there is no fixed iron to close on; is the "
                "direction right, "
                "have groups the roles fixed and armature?");
    return;
  }
  if (std::fabs(gap - drawn_gap) <= 0.01 * drawn_gap + 1e-6) return;
  reader.fail("", "drawn_gap_mm",
              fmt::format("the faces of the mesh are {:.4g} mm apart{}", gap * 1e3,
                          better_unit(unit, gap, 0.99 * drawn_gap, 1.01 * drawn_gap)));
}

void check_drawn_reach(FileReader& reader, double from, double to, double residual_gap, double travel) {
  if (residual_gap <= from)
    reader.fail("", "residual_gap_um",
                fmt::format("the mesh turns inside out on the way there: what stretches of it does so down "
                            "to a gap of {:.4g} um",
                            from * 1e6));
  const double open = 1.5 * travel + residual_gap;
  if (open >= to)
    reader.fail("", "travel_mm",
                fmt::format("the mesh turns inside out: at 1.5 times this travel the faces are {:.4g} mm "
                            "apart, what stretches of it does so to {:.4g} mm",
                            open * 1e3, to * 1e3));
}

}  // namespace powbench::host
