#include <cstdlib>
#include <filesystem>

#include "rigs/qemu_process.h"
#include "rigs/rig.h"

/// Apart from the process: only this file knows a folder of the build.

namespace powbench::rigs {

std::string find_qemu_image() {
  namespace fs = std::filesystem;
  if (const char* chosen = std::getenv("POWBENCH_FIRMWARE"); chosen != nullptr && *chosen != '\0') {
    if (!fs::exists(chosen))
      throw RigError(std::string("POWBENCH_FIRMWARE names '") + chosen + "', which does not exist");
    return chosen;
  }
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* place : {"powbench-qemu.elf", "../lib/powbench/powbench-qemu.elf"})
    if (fs::exists(folder / place, ignored)) return (folder / place).lexically_normal().string();
  const std::string built = POWBENCH_QEMU_IMAGE;
  if (!built.empty() && fs::exists(built, ignored)) return built;
  throw RigError(
      "there is no image for the emulated board: install the package powbench-firmware or, where powbench "
      "was built from its "
      "sources, gcc-arm-none-eabi, libnewlib-arm-none-eabi and libstdc++-arm-none-eabi-newlib and build "
      "again; or let "
      "POWBENCH_FIRMWARE name one");
}

}  // namespace powbench::rigs
