#include "tests/places.h"

namespace powbench::test {

std::string source_dir() {
  return POWBENCH_SOURCE_DIR;
}
std::string build_dir() {
  return POWBENCH_BINARY_DIR;
}
std::string program() {
  return POWBENCH_PROGRAM;
}
std::string page_tools() {
  return source_dir() + "/build/page_tools";
}
std::string reset_image() {
  return POWBENCH_QEMU_CHECK_IMAGE;
}

}  // namespace powbench::test
