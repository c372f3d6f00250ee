#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "host/config/drawing_keys.h"
#include "host/config/file_reader.h"
#include "sim/magnetics/plane/msh.h"

/// What drawing files in the plane and in space have in common. Private to drawing_file.cpp and space_file.cpp.

namespace powbench::host {

/// The mesh that the drawing file names; where it cannot be read, BadInput about the line of the key alone.
sim::MshMesh mesh_of_drawing(const std::filesystem::path& file, const std::string& mesh);

/// The steels of a drawing, each once: built-in ones, and sheets beside the drawing, with their share of the stack.
class DrawnSteels {
 public:
  DrawnSteels(FileReader& reader, std::filesystem::path folder)
      : reader_(reader), folder_(std::move(folder)) {}
  /// Index in `list` of the one that a group names; -1 and an error of the reader where there is none.
  int index(const std::string& section, const std::string& name, double stack_factor,
            std::vector<sim::Steel>& list);

 private:
  FileReader& reader_;
  std::filesystem::path folder_;
  std::map<std::string, int> known_;
};

/// "; in UNIT it would be ... mm" for another unit in which a length lies within a range; else "".
std::string better_unit(DrawnUnit, double length, double low, double high);

/// Checks the extent of the mesh and the distance of its faces, m, against what the file says of unit, opening and gap.
void check_drawn_size(FileReader&, DrawnUnit, double extent, double measured_gap, double drawn_gap);

/// Checks the gaps (faces) at which the mesh turns inside out against residual gap and travel, m.
void check_drawn_reach(FileReader&, double from, double to, double residual_gap, double travel);

}  // namespace powbench::host
