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

struct CircuitArgs {
  std::string file;
  double volts = 230, hertz = 50;  ///< rated: the circuit is sought up to 1.3 times their flux linkage
  std::string cache = "field";     ///< folder of field tables
  std::string accuracy = "1%";     ///< of the table
  bool json = false;
};

/// The lumped circuit nearest to the specimen's field, as lines of a specimen file, with its deviations. Throws
/// BadInput for a bad file or one without a field.
Exit identify_specimen_circuit(const CircuitArgs&);

/// Derived numbers beside catalogue ranges. Throws BadInput for a bad file.
Exit describe_specimen(const SpecimenArgs&);

/// A file from before the restitutions were rebounds, as one of now, to stdout.
Exit convert_specimen(const SpecimenArgs&);

}  // namespace powbench::host
