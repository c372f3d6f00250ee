#pragma once

#include <optional>
#include <string>

#include "host/config/steel_file.h"
#include "sim/magnetics/steel.h"

namespace powbench::host {

/// A steel as the command line names it.
struct NamedSteel {
  std::string name;
  sim::Steel steel;
  std::optional<SteelSheet> sheet;  ///< of a file
};

/// A built-in steel by its name, or a B-H sheet by its file. Throws BadInput.
NamedSteel named_steel(const std::string& word);

}  // namespace powbench::host
