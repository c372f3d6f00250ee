#pragma once

#include <filesystem>
#include <string>

#include "host/config/bad_input.h"
#include "sim/models/solenoid/solenoid_specimen.h"

/// A specimen file with `kind = "solenoid"`: shape, steel, coil, plunger and load of one solenoid. Owner: its designer.

namespace powbench::host {

/// True if the file says ahead of its first section that it is no contactor: `kind = "solenoid"`, or a word that
/// `read_solenoid` refuses. A file that cannot be read says nothing.
bool is_solenoid_file(const std::filesystem::path&);

/// Throws BadInput that names the file where it is that of a solenoid: what only takes contactors asks here first.
void refuse_solenoid(const std::filesystem::path&);

/// Throws BadInput with all mistakes, those of sim::require_valid included.
sim::SolenoidSpecimen read_solenoid(const std::filesystem::path&);

/// Commented file of the default solenoid.
std::string solenoid_template();

}  // namespace powbench::host
