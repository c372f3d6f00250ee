#pragma once

#include <string>
#include <string_view>

#include "fmu/variables.h"

namespace powbench::fmu {

/// Name of the shared library in the unit, without its ending.
inline constexpr const char* model_identifier = "powbench_contactor";

/// The folder of the library for this machine: of FMI 2.0 `linux64`, of FMI 3.0 `x86_64-linux` or its like.
std::string binary_folder(Fmi);

/// modelDescription.xml. `token`: GUID or instantiation token.
std::string model_description(const sim::Specimen&, Fmi, std::string_view token, std::string_view version);

}  // namespace powbench::fmu
