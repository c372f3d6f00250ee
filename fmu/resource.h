#pragma once

#include <string>
#include <string_view>

#include "sim/specimen/specimen.h"

/// The specimen as the unit carries it with it: resources/contactor.txt. Its numbers are SI with all digits, so that
/// the unit computes with the same bits as the native simulation.

namespace powbench::fmu {

inline constexpr const char* resource_name = "contactor.txt";

/// One `section.key = value` a line, behind a line that names the program's version.
std::string resource_text(const sim::Specimen&, std::string_view version);

/// Throws std::invalid_argument, one sentence: another format, a key that is missing or not known, no number.
sim::Specimen parse_resource(std::string_view text);

/// What model description and library must agree on, in the form of a GUID: a hash (FNV-1a) of the text.
std::string token_of(std::string_view text);

/// Reads `folder`/contactor.txt. Throws std::invalid_argument where that cannot be done.
std::string read_resource(const std::string& folder);

/// The folder that a `file:` URI names, its %XX decoded. Throws std::invalid_argument for another URI.
std::string folder_of_uri(std::string_view uri);

}  // namespace powbench::fmu
