#pragma once

#include <set>
#include <string>

#include "host/config/file_kind.h"

namespace powbench::host {

/// What to say of a key that a section of this kind of file does not have: the key that was meant here or elsewhere,
/// the section that is named like it, or the keys that there are.
std::string unknown_key(const FileKind&, const std::string& section, const std::string& key);

/// The same of a section. Of the groups of a mesh, [group.NAME], all are listed, those that are not `there` yet, and of
/// these the one that was meant.
std::string unknown_section(const FileKind&, const std::string& section, const std::set<std::string>& there);

}  // namespace powbench::host
