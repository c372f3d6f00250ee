#include "host/export/fmu.h"

#include <fstream>
#include <iterator>

#include "core/version.h"
#include "fmu/description.h"
#include "fmu/resource.h"
#include "host/config/bad_input.h"
#include "host/export/zip.h"

namespace powbench::host {

std::filesystem::path fmu_library() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  const std::string name = std::string(fmu::model_identifier) + ".so";
  for (const char* place : {"../fmu", "../lib/powbench"})
    if (fs::exists(folder / place / name, ignored)) return (folder / place / name).lexically_normal();
  throw BadInput({name + ": not found in ../fmu and ../lib/powbench next to the program; install the package "
                         "powbench whole, or build its target powbench_contactor"});
}

std::string to_fmu(const sim::Specimen& specimen, const std::string& specimen_text, fmu::Fmi fmi) {
  const auto library = fmu_library();
  std::ifstream in(library, std::ios::binary);
  const std::string binary{std::istreambuf_iterator<char>(in), {}};
  if (!in || binary.empty()) throw BadInput({library.string() + ": cannot be read"});
  const std::string numbers = fmu::resource_text(specimen, program_version);
  Zip zip;
  zip.add("modelDescription.xml",
          fmu::model_description(specimen, fmi, fmu::token_of(numbers), program_version));
  zip.add(std::string("resources/") + fmu::resource_name, numbers);
  zip.add("resources/specimen.toml", specimen_text);
  zip.add("binaries/" + fmu::binary_folder(fmi) + "/" + fmu::model_identifier + ".so", binary);
  return zip.finish();
}

}  // namespace powbench::host
