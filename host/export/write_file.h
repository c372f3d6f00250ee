#pragma once

#include <filesystem>
#include <string_view>

namespace powbench::host {

/// Writes a file that a person has asked for. Throws BadInput with its name where that cannot be done: the place is
/// not the program's.
void write_file(const std::filesystem::path&, std::string_view text);

}  // namespace powbench::host
