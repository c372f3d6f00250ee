#include "host/import/foreign_table.h"

#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "host/config/bad_input.h"
#include "host/import/comtrade.h"
#include "host/import/lvm.h"
#include "host/import/mat5.h"
#include "host/import/scope_csv.h"
#include "host/import/tdms.h"
#include "host/import/wav.h"
#include "host/import/wvf.h"

namespace powbench::host {

namespace fs = std::filesystem;

namespace {

std::string ending_of(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

/// The file of the same name with this ending, in either case.
fs::path beside(const fs::path& path, std::string ending) {
  fs::path other = path;
  std::error_code ignored;
  if (fs::exists(other.replace_extension(ending), ignored)) return other;
  for (char& c : ending) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (fs::exists(other.replace_extension(ending), ignored)) return other;
  throw BadInput(
      {path.string() + ": " + other.filename().string() + " is missing beside it: copy both files"});
}

}  // namespace

CsvTable parse_table(std::string_view bytes, const std::string& file) {
  const std::string ending = ending_of(file);
  if (bytes.starts_with("TDSm") || ending == ".tdms") return parse_tdms(bytes, file);
  if (bytes.starts_with("MATLAB ") || ending == ".mat") return parse_mat(bytes, file);
  if (is_wav(file)) return parse_wav(bytes, file);
  if (is_lvm(file) || bytes.starts_with("LabVIEW Measurement")) return parse_lvm(bytes, file);
  if (is_scope_csv(bytes)) return read_scope_csv(bytes, file);
  return read_csv(bytes, file);
}

CsvTable read_table(const fs::path& path) {
  if (is_comtrade(path)) return to_table(read_comtrade(path));
  const std::string ending = ending_of(path);
  if (ending == ".wvf" || ending == ".hdr") {
    const fs::path header = ending == ".hdr" ? path : beside(path, ".hdr");
    const fs::path data = ending == ".wvf" ? path : beside(path, ".wvf");
    return parse_wvf(whole_file(header), whole_file(data), header.string(), data.string());
  }
  return parse_table(whole_file(path), path.string());
}

std::string whole_file(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw BadInput({path.string() + ": is a directory, not a file"});
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw BadInput({path.string() + ": cannot be read: " + std::strerror(errno != 0 ? errno : ENOENT)});
  return std::string(std::istreambuf_iterator<char>(in), {});
}

}  // namespace powbench::host
