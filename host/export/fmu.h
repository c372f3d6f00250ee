#pragma once

#include <filesystem>
#include <string>

#include "fmu/variables.h"
#include "sim/specimen/specimen.h"

namespace powbench::host {

/// The library that goes into a mock-up unit: in the build's own folder or where the package puts it, seen from the
/// program. Throws BadInput where it is not there.
std::filesystem::path fmu_library();

/// A functional mock-up unit of the specimen, a zip file. `specimen_text`: the specimen file, kept in it for people.
std::string to_fmu(const sim::Specimen&, const std::string& specimen_text, fmu::Fmi);

}  // namespace powbench::host
