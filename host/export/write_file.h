#pragma once

#include <filesystem>
#include <string_view>

namespace powbench::host {

/// Writes a file that a person has asked for. Throws BadInput with its name where that cannot be done: the place is
/// not the program's.
void write_file(const std::filesystem::path&, std::string_view text);

/// For a file that a person may have edited since, or that took hours: throws BadInput where it is there already and
/// `overwrite` was not asked for. Call it before the work.
void refuse_existing(const std::filesystem::path&, bool overwrite);

}  // namespace powbench::host
