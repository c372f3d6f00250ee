#pragma once

#include <string>
#include <vector>

namespace powbench::bench {

/// One figure of what the firmware costs on a Cortex-M4F.
struct CostRow {
  std::string name;  ///< key in the baseline
  std::string unit;
  double value;
  double budget = 0;  ///< most it may be; 0: no budget but the baseline
};

/// Instructions of the control path over two shots of the reference specimen on the emulated board, counted
/// exactly, and the memory that its image takes. The same image gives the same figures on every machine.
/// Throws RigError when the emulated board cannot be had.
std::vector<CostRow> measure_firmware_cost();

}  // namespace powbench::bench
