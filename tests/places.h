#pragma once

#include <string>

/// Where this build and its sources lie: absolute paths, without a slash at the end.

namespace powbench::test {

std::string source_dir();
std::string build_dir();
std::string program();      ///< powbench
std::string page_tools();   ///< what `./dev test --slow` fetched for the pages
std::string reset_image();  ///< image for the emulated board that is reset on purpose; empty: not built

}  // namespace powbench::test
