#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/events.h"
#include "core/record.h"

/// The ways to find contacts that the score compares, from the textbook chain to the full extraction.

namespace powbench::bench {

struct Method {
  std::string_view name;
  std::vector<Contact> (*contacts)(const Record&);  ///< of film A; u = NaN where the method gives none
};

/// threshold, hysteresis, hinge, pulse fit, full chain
std::span<const Method> methods();

}  // namespace powbench::bench
