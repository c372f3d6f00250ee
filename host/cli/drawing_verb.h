#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "host/cli/verbs.h"
#include "sim/field3d/space_magnet.h"
#include "sim/fields/drawn_magnet.h"
#include "sim/fields/potential_table.h"

namespace powbench::host {

/// Table and pictures of a drawn magnet: `powbench field x.magnet.toml`.
Exit show_drawing(const FieldArgs&, const std::shared_ptr<const sim::DrawnMagnet>&);

/// The same of a magnet drawn in space.
Exit show_space_drawing(const FieldArgs&, const std::shared_ptr<const sim::SpaceMagnet>&);

/// Throws BadInput for options of `field` that do not go with a drawing.
void refuse_drawing_options(const FieldArgs&);

/// That mesh or table miss the accuracy asked for, and what helps; "" when they do not.
std::string missed_accuracy(const sim::PotentialTable&, double asked, std::string_view finer);

/// How much of a table rests on extrapolated steel, in a few words.
std::string extrapolated_text(const sim::PotentialTable&, const sim::ExtrapolatedShare&);

}  // namespace powbench::host
