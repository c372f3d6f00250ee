#pragma once

#include <string>
#include <vector>

#include "host/paper/evaluate.h"

/// `powbench tables` as text for a terminal and as JSON for programs.

namespace powbench::host {

/// Aligned columns, one line a row, excluded rows marked x, misprinted errors marked *; then the mean and the largest
/// error per quantity, ours beside the paper's own. At most 130 columns wide, ASCII.
std::string tables_text(const std::vector<TableRow>&);

/// A list of objects {paper, table, theta_deg, quantity, unit, published_simulation, published_measurement,
/// published_error_percent, ours, error_percent, held_out, held_out_error_percent, excluded,
/// recomputed_published_error_percent, note}. What is unknown is null; table is null for statements in the text.
std::string tables_json(const std::vector<TableRow>&);

}  // namespace powbench::host
