#pragma once

#include <string>

/// Who owns a rig while this program fires it: a name for others, and a token that only this program knows.

namespace powbench::rigs {

/// A rig that is open to a network wants its secret in front: that of POWBENCH_RIG_SECRET.
std::string make_token();
/// "powbench-PID@HOST", as long as a lease takes.
std::string make_name();

}  // namespace powbench::rigs
