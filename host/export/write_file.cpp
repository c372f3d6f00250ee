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

}  // namespace powbench::host
