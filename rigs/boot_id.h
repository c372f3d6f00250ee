#pragma once

#include <cstdint>
#include <string>

namespace powbench::rigs {

/// What tells one start of a simulated board from every other: a hash of its serial number, `seed` and the number of
/// the start in this process. The same program gives the same sequence at every run.
std::string next_boot_id(const std::string& serial, std::uint64_t seed = 1);

}  // namespace powbench::rigs
