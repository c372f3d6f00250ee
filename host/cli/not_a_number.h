#pragma once

#include <string>

namespace CLI {
class App;
}

namespace powbench::host {

/// The option of the chosen verb that was given nan for a number, in a sentence; "" where there is none. Ranges do not
/// see it: every comparison with it is false.
std::string not_a_number(const CLI::App&);

}  // namespace powbench::host
