#include "host/export/write_file.h"

#include <fstream>

#include "host/config/bad_input.h"

namespace powbench::host {

void write_file(const std::filesystem::path& path, std::string_view text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out)
    throw BadInput({path.string() +
                    ": cannot be written; check the folder, its permissions and the disk, or name another"});
}

void refuse_existing(const std::filesystem::path& path, bool overwrite) {
  std::error_code ignored;
  if (!path.empty() && !overwrite && std::filesystem::exists(path, ignored))
    throw BadInput(
        {path.string() + ": is there already and is not overwritten; name another file, or add --overwrite"});
}

}  // namespace powbench::host
