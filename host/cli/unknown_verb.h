#pragma once

#include <string>

namespace CLI {
class App;
}

namespace powbench::host {

/// A first word that is no verb, with the one that was meant by its letters or by its sense; "" when it is one.
std::string unknown_verb(const CLI::App&, int argc, char** argv);

}  // namespace powbench::host
