#pragma once

#include <cstdlib>
#include <string>

#include "host/config/bad_input.h"

namespace powbench::host {

/// A share written as "1%" or "0.01", low .. high; BadInput names the option.
inline double share_option(const std::string& option, const std::string& word, double low, double high,
                           const std::string& allowed) {
  char* end = nullptr;
  double value = std::strtod(word.c_str(), &end);
  const std::string rest = end;
  if (rest == "%") value /= 100;
  if (end == word.c_str() || (rest != "%" && !rest.empty()) || !(value >= low && value <= high))
    throw BadInput({option + " = " + word + ", allowed " + allowed});
  return value;
}

}  // namespace powbench::host
