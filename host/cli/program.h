#pragma once

#include <string>

#include "core/version.h"

/// Which program this is.

namespace powbench::host {

/// The commit of the sources, behind "-dirty-" a hash of what was changed since; "not known" without git. Made by the
/// build.
extern const char* const program_commit;

/// Version and commit: what a stored point of a study depends on, besides its conditions.
inline std::string program_identity() {
  return std::string(program_version) + " " + program_commit;
}

}  // namespace powbench::host
