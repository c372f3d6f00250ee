#pragma once

#include <optional>
#include <string>

#include "core/outcome.h"

/// `powbench specimen`: what the numbers of a specimen file make together.

namespace powbench::host {

struct SpecimenArgs {
  std::string file;                    ///< "" = the reference contactor
  std::optional<double> volts, hertz;  ///< none: 230 V, 50 Hz; of a solenoid 24 V
  bool json = false;
};

/// Derived numbers beside catalogue ranges. Throws BadInput for a bad file.
Exit describe_specimen(const SpecimenArgs&);

/// A file from before the restitutions were rebounds, as one of now, to stdout.
Exit convert_specimen(const SpecimenArgs&);

}  // namespace powbench::host
