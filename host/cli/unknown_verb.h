#pragma once

#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace powbench::host {

/// A first word that is no verb, with the one that was meant by its letters or by its sense; "" when it is one.
std::string unknown_verb(const CLI::App&, int argc, char** argv);

/// One line for words that the verb cannot use: what is wrong, the option that was meant, where help is.
std::string parse_failure(const CLI::App*, const CLI::Error&);

}  // namespace powbench::host
