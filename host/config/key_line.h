#pragma once

#include <string>

namespace powbench::host {

/// A key of a file as a form shows it; texts as they stand in a file.
struct KeyLine {
  std::string section, section_meaning, key, unit, allowed, meaning;
  std::string value;  ///< "" = none
  bool required = false;
  bool words = false;  ///< a text: stands in quotes
};

}  // namespace powbench::host
