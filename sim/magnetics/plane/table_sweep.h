#pragma once

#include <functional>
#include <vector>

#include "sim/magnetics/plane/field_four.h"
#include "sim/magnetics/plane/table_build.h"

namespace powbench::sim {

/// The loop that fills a table from any field in the plane or around an axis: a table without its estimates, hash and
/// description. Four gaps make a slice, the last one filled up with the last gap; slices are shared out over the team,
/// after the jobs `beside`. Empty where `source` leaves out a slice. Throws std::runtime_error where Newton does not
/// converge.
PotentialTable fill_table(const TablePlan&, bool ring, Team&, const GapField& prototype, const NewtonOptions&,
                          TableReport*, const SliceSource& source = {},
                          const std::vector<std::function<void()>>& beside = {});

}  // namespace powbench::sim
