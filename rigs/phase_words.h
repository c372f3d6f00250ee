#pragma once

#include <string>
#include <string_view>

/// What a rig says of its mains, in a sentence.

namespace powbench::rigs {

/// From the attributes `phase_faults` ("144 cross_check disturbed") and `phase_u_millideg` ("4 6": now, 20 ms ahead).
/// Unknown words are passed on as they are; what is no such text gives "not known".
std::string phase_words(std::string_view faults, std::string_view uncertainty);

}  // namespace powbench::rigs
