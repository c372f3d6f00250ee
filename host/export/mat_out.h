#pragma once

#include <string>
#include <vector>

namespace powbench::host {

/// A real matrix, row by row.
struct MatVariable {
  std::string name;
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;
};

/// MAT-file of level 5 without compression, as MATLAB (-v6), Octave, scipy and Modelica's table blocks read it.
std::string to_mat(const std::vector<MatVariable>&);

}  // namespace powbench::host
