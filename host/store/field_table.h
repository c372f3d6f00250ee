#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/magnetics/plane/drawn_magnet.h"
#include "sim/magnetics/plane/solenoid_field.h"
#include "sim/magnetics/plane/table_build.h"
#include "sim/magnetics/space/end_table.h"
#include "sim/magnetics/space/space_magnet.h"

/// Tables of the magnetic potential on disk: a text header with version, units and sizes, the numbers as little-endian
/// doubles, a CRC-32 at the end. Named after the hash of everything they depend on.

namespace powbench::host {

std::string field_table_bytes(const sim::PotentialTable&);

/// Throws StoreError with one sentence (named `where`) for another format or version, a length that does not fit, a
/// checksum that does not match, or a table that `check_table` refuses.
sim::PotentialTable parse_field_table(std::string_view bytes, const std::string& where);

/// Writes beside the target and renames: a reader sees the old file or the new one. Throws StoreError.
void save_field_table(const std::filesystem::path&, const sim::PotentialTable&);
sim::PotentialTable load_field_table(const std::filesystem::path&);

struct FieldTableChoice {
  sim::PotentialTable table;
  std::filesystem::path file;
  bool reused = false;
  sim::TableReport report;  ///< of the build; zeros where reused
  double cpu_seconds = 0;   ///< of the build, all threads
};

/// The table of this design from `folder` if it is there and whole, else built and stored there. A damaged file is an
/// error, not rebuilt in silence.
FieldTableChoice obtain_field_table(const std::filesystem::path& folder, const sim::MagnetDesign&,
                                    const sim::TableOptions&, sim::Team&, const sim::SliceSource& = {});

/// The same for a drawn magnet.
FieldTableChoice obtain_field_table(const std::filesystem::path& folder,
                                    const std::shared_ptr<const sim::DrawnMagnet>&, const sim::TableOptions&,
                                    sim::Team&);

/// The same for a magnet drawn in space.
FieldTableChoice obtain_field_table(const std::filesystem::path& folder, const sim::SpaceMagnet&,
                                    const sim::TableOptions&, const sim::space::Progress&);

/// The same for a solenoid.
FieldTableChoice obtain_field_table(const std::filesystem::path& folder, const sim::SolenoidDesign&,
                                    const sim::TableOptions&, sim::Team&);

/// The same for the table with the ends of three dimensions, with the ring as a variable or without.
FieldTableChoice obtain_end_table(const std::filesystem::path& folder, const sim::MagnetDesign&,
                                  const sim::TableOptions&, const sim::EndTableOptions&, sim::Team&);

}  // namespace powbench::host
