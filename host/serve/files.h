#pragma once

#include <string>
#include <vector>

#include "host/config/key_line.h"

namespace powbench::host {

/// The file that a person would write for these values: the required keys, and what differs from the default, with
/// meaning and range behind each.
std::string written_file(const std::string& kind, const std::vector<KeyLine>& values,
                         const std::vector<KeyLine>& defaults);

/// Replaces a file in one step: it is the old one or the new one, also after a power cut. Throws StoreError.
void replace_file(const std::string& path, const std::string& text);

}  // namespace powbench::host
