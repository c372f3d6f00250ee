#pragma once

/// The program version, stored with every result.
namespace powbench {
inline constexpr const char* program_version = "0.1.0";
}
