#include "host/store/field_table.h"

#include <bit>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <sstream>

#include "core/cpu_time.h"
#include "core/crc32.h"
#include "host/store/store.h"

namespace powbench::host {
namespace {

constexpr std::string_view magic = "powbench field table 3";
constexpr std::size_t checksum_size = 4;

std::uint32_t checksum(std::string_view bytes) {
  return crc32({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

std::string hash_text(std::uint64_t hash) {
  char text[20];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

/// One list of numbers: its key in the header, its unit, its place.
struct Column {
  const char* key;
  const char* unit;
  std::vector<double> sim::PotentialTable::*values;
};

constexpr Column columns[] = {
    {"psi", "Wb", &sim::PotentialTable::psi},
    {"ring", "Wb", &sim::PotentialTable::ring},
    {"gap", "m", &sim::PotentialTable::gap},
    {"nodes", "J_and_derivatives_by_Wb_Wb_m", &sim::PotentialTable::nodes},
    {"air", "A/Wb_and_A/Wb/m", &sim::PotentialTable::air},
    {"current_error", "1", &sim::PotentialTable::current_error},
    {"pull_error", "1", &sim::PotentialTable::pull_error},
    {"steel_field", "T", &sim::PotentialTable::steel_field},
};

static_assert(std::endian::native == std::endian::little, "the numbers are stored as they lie in memory");

}  // namespace

std::string field_table_bytes(const sim::PotentialTable& t) {
  std::ostringstream out;
  out.precision(17);
  out << magic << '\n'
      << "hash " << hash_text(t.design_hash) << '\n'
      << "mesh_error " << t.mesh_error << '\n'
      << "data_end " << t.data_end << '\n'
      << "ring_ratio " << t.ring_ratio << '\n';
  for (const auto& c : columns) out << c.key << ' ' << (t.*c.values).size() << ' ' << c.unit << '\n';
  out << "description " << t.description << '\n';
  std::string bytes = out.str();
  for (const auto& c : columns) {
    const auto& values = t.*c.values;
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  }
  const std::uint32_t sum = checksum(bytes);
  bytes.append(reinterpret_cast<const char*>(&sum), checksum_size);
  return bytes;
}

sim::PotentialTable parse_field_table(std::string_view bytes, const std::string& where) {
  const auto fail = [&](const std::string& why) -> StoreError { return StoreError(where + ": " + why); };
  if (!bytes.starts_with(magic.substr(0, magic.rfind(' '))))
    throw fail("not a table of the magnetic potential");
  if (!bytes.starts_with(std::string(magic) + '\n'))
    throw fail("a table of another version; delete it to have it built anew");
  if (bytes.size() < magic.size() + checksum_size) throw fail("damaged: the file ends early");
  std::uint32_t stored = 0;
  std::memcpy(&stored, bytes.data() + bytes.size() - checksum_size, checksum_size);
  const std::string_view content = bytes.substr(0, bytes.size() - checksum_size);
  if (checksum(content) != stored)
    throw fail("damaged: the checksum does not match; delete it to have it built anew");
  const std::size_t last_line = content.find("\ndescription ");
  const std::size_t data =
      last_line == std::string_view::npos ? last_line : content.find('\n', last_line + 1);
  if (data == std::string_view::npos) throw fail("damaged: the header has no end");
  std::istringstream header{std::string(content.substr(magic.size() + 1, data - magic.size()))};
  sim::PotentialTable t;
  std::string key, unit, hash;
  header >> key >> hash >> key >> t.mesh_error >> key >> t.data_end >> key >> t.ring_ratio;
  t.design_hash = std::strtoull(hash.c_str(), nullptr, 16);
  std::size_t at = data + 1;
  for (const auto& c : columns) {
    std::size_t count = 0;
    if (!(header >> key >> count >> unit) || key != c.key)
      throw fail("damaged: the header misses '" + std::string(c.key) + "'");
    if (count > (content.size() - at) / sizeof(double))
      throw fail("damaged: fewer numbers than the header says");
    auto& values = t.*c.values;
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), content.data() + at, count * sizeof(double));
    at += count * sizeof(double);
  }
  t.description = content.substr(last_line + 13, data - last_line - 13);
  try {
    sim::check_table(t);
  } catch (const std::invalid_argument& error) {
    throw fail(error.what());
  }
  return t;
}

void save_field_table(const std::filesystem::path& path, const sim::PotentialTable& t) {
  const auto beside = path.string() + ".part";
  const std::string bytes = field_table_bytes(t);
  std::ofstream out(beside, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, path, error);
  if (!out || error) throw StoreError(path.string() + ": cannot be written");
}

sim::PotentialTable load_field_table(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream bytes;
  if (in) bytes << in.rdbuf();
  if (!in) throw StoreError(path.string() + ": cannot be read");
  return parse_field_table(bytes.str(), path.string());
}

namespace {

/// From the folder, or from `build`.
FieldTableChoice obtain(const std::filesystem::path& folder, std::uint64_t hash,
                        const std::function<sim::PotentialTable(sim::TableReport*)>& build) {
  FieldTableChoice choice;
  choice.file = folder / ("field-" + hash_text(hash) + ".table");
  if (std::filesystem::exists(choice.file)) {
    choice.table = load_field_table(choice.file);
    if (choice.table.design_hash != hash)
      throw StoreError(choice.file.string() +
                       ": the table of another design; delete it to have it built anew");
    choice.reused = true;
    return choice;
  }
  std::filesystem::create_directories(folder);
  const double start = process_cpu_seconds();
  choice.table = build(&choice.report);
  choice.cpu_seconds = process_cpu_seconds() - start;
  save_field_table(choice.file, choice.table);
  return choice;
}

}  // namespace

FieldTableChoice obtain_field_table(const std::filesystem::path& folder, const sim::MagnetDesign& design,
                                    const sim::TableOptions& options, sim::Team& team,
                                    const sim::SliceSource& source) {
  return obtain(folder, sim::table_hash(design, options), [&](sim::TableReport* report) {
    return sim::build_table(design, options, team, report, source);
  });
}

FieldTableChoice obtain_field_table(const std::filesystem::path& folder,
                                    const std::shared_ptr<const sim::DrawnMagnet>& drawing,
                                    const sim::TableOptions& options, sim::Team& team) {
  auto choice = obtain(folder, sim::table_hash(*drawing, options), [&](sim::TableReport* report) {
    return sim::build_table(drawing, options, team, report);
  });
  sim::refuse_mesh_error(choice.table.mesh_error);  // of a table that an earlier release stored
  return choice;
}

FieldTableChoice obtain_field_table(const std::filesystem::path& folder, const sim::SpaceMagnet& drawing,
                                    const sim::TableOptions& options, const sim::space::Progress& progress) {
  auto choice = obtain(folder, sim::table_hash(drawing, options), [&](sim::TableReport* report) {
    return sim::build_table(drawing, options, report, progress);
  });
  sim::refuse_mesh_error(choice.table.mesh_error);
  return choice;
}

FieldTableChoice obtain_field_table(const std::filesystem::path& folder, const sim::SolenoidDesign& design,
                                    const sim::TableOptions& options, sim::Team& team) {
  return obtain(folder, sim::table_hash(design, options),
                [&](sim::TableReport* report) { return sim::build_table(design, options, team, report); });
}

FieldTableChoice obtain_end_table(const std::filesystem::path& folder, const sim::MagnetDesign& design,
                                  const sim::TableOptions& options, const sim::EndTableOptions& ends,
                                  sim::Team& team) {
  return obtain(folder, sim::end_table_hash(design, options, ends), [&](sim::TableReport* report) {
    return sim::build_table_with_ends(design, options, ends, team, report);
  });
}

}  // namespace powbench::host
