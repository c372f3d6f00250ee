#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/config/bad_input.h"
#include "host/config/key_line.h"
#include "sim/specimen/specimen.h"

/// The specimen file: one contactor. Owner: its designer. Keys have their unit; ranges: sim/specimen/validate.

namespace powbench::host {

/// Throws BadInput with all mistakes, those of sim::validate included.
sim::Specimen read_specimen(const std::filesystem::path&);
sim::Specimen parse_specimen(std::string text, std::string file);

/// Commented file of the reference contactor.
std::string specimen_template();

/// Every key with its value.
std::vector<KeyLine> keys_of(const sim::Specimen&);

/// Canonical text: equal specimens give equal bytes. Hash and store this.
std::string resolved_text(const sim::Specimen&);

}  // namespace powbench::host
