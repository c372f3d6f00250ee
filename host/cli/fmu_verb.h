#pragma once

#include <string>

#include "core/outcome.h"

namespace powbench::host {

struct FmuArgs {
  std::string specimen_file;  ///< "" = the reference contactor
  std::string output = "contactor.fmu";
  int fmi = 2;  ///< 2 or 3
  bool json = false;
};

/// A contactor as a functional mock-up unit for other people's simulators.
Exit make_fmu(const FmuArgs&);

}  // namespace powbench::host
