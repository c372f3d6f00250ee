#include "host/cli/not_a_number.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

namespace powbench::host {
namespace {

bool is_nan(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0' && std::isnan(value);
}

}  // namespace

std::string not_a_number(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options())
    if (option->get_type_name().find("FLOAT") != std::string::npos)
      for (const std::string& text : option->results())
        if (is_nan(text))
          return fmt::format("powbench {}: {} {}: not a number; {}", app.get_name(), option->get_name(), text,
                             option->get_description());
  for (const CLI::App* verb : app.get_subcommands())
    if (std::string wrong = not_a_number(*verb); !wrong.empty()) return wrong;
  return "";
}

}  // namespace powbench::host
