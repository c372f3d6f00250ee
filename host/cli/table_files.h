#pragma once

#include <string>

#include "host/cli/verbs.h"
#include "sim/magnetics/table/potential_table.h"

/// `field --out`: a magnet's table for other simulators.

namespace powbench::host {

/// Refuses a file for other simulators before anything is computed.
void check_tables(const FieldArgs&);

/// Writes what was asked for, with positions up to `travel`, m; says how well the rows can be interpolated.
void write_tables(const FieldArgs&, const sim::TablePotential&, double travel, const std::string& title);

}  // namespace powbench::host
